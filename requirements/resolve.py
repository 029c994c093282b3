"""
Resolve the ranges in setup.py to exact versions, for every Python that has ROS 2 wheels.

Each version comes with the hashes of its files, so that pip takes no other file for it. Extras
stay beside their names: pip else takes the newest of a package that is asked for with an extra.
"""

from pathlib import Path
import re
import subprocess
import sys

HERE = Path(__file__).parent
HEADER = '# Written by `make lock` from setup.py: change the ranges there.\n'

# What the ROS 2 wheels are built for. It holds for every line, so no line needs to say it.
EVERYWHERE = re.compile(
    r" and platform_machine == 'x86_64'| and sys_platform == 'linux'"
    r"| and platform_python_implementation != 'PyPy'"
    r"| ; python_full_version < '3\.14'| and python_full_version < '3\.14'")


def resolve(lock: Path, *extras: str, within: Path | None = None) -> None:
    """Write the exact versions of the package with `extras` to `lock`, near what it holds."""
    command = [sys.executable, '-m', 'uv', 'pip', 'compile', 'setup.py', '--universal',
               '--python-version', '3.10', '--no-python-downloads', '--no-emit-index-url',
               '--no-header', '--quiet', '--generate-hashes', '--no-strip-extras',
               '--output-file', str(lock)]
    command += [f'--extra={extra}' for extra in extras]
    command += [f'--constraint={within}'] if within else []
    subprocess.run(command, cwd=HERE.parent, check=True)
    lock.write_text(HEADER + EVERYWHERE.sub('', lock.read_text()))


if __name__ == '__main__':
    subprocess.run([sys.executable, '-m', 'pip', 'install', '-qq', 'uv'], check=True)
    resolve(HERE / 'lock.txt', 'ros', 'test', 'lint', 'docs', 'live')
    resolve(HERE / 'fleet.txt', 'fleet', within=HERE / 'lock.txt')
