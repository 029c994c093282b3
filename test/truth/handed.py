"""
Hand arrays on in compiled code without counting who holds them.

The count is an atomic operation at every call, and most of what a step of the arm took. It is for
arguments alone: the caller keeps them alive.
"""

from typing import Any

from numba.core import cgutils
from numba.extending import intrinsic


def _uncounted(typing: Any, array: Any) -> Any:
    """Return code that makes a view of an array which nobody owns."""
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = context.make_array(signature.args[0])(context, builder, arguments[0])
        view.meminfo = cgutils.get_null_value(view.meminfo.type)
        view.parent = cgutils.get_null_value(view.parent.type)
        return view._getvalue()

    return array(array), generate


uncounted: Any = intrinsic(_uncounted)
