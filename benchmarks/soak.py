"""
Run the closed loop and the recorder for a long time; watch rate, losses, latency and memory.

`soak.py [MINUTES] [--quick]`, ten unless given. Memory may not grow by more than a tenth after
the first minute, and no sample may get lost.
"""

from collections.abc import Mapping
from pathlib import Path
import resource
import sys
import tempfile

from bench_three_processes import CONTROL, lost
from nodes import Listener, nodes, own_domain
from size import parser, verdict

RATE, MINUTE = 500.0, 60.0      # [Hz]; between lines [s]
TINY = 50.0, 2.0, 2             # rate, time between lines, and lines of a tiny case
GROWTH = 1.1            # of the memory after the first minute
NAMES = ('arm_sim', 'torque_estimator', 'jtf_controller', 'bag_recorder')


def memory(process_id: int) -> float:
    """Return the resident memory of a process [MB]."""
    pages = int(Path(f'/proc/{process_id}/statm').read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def row(minute: int, controller: Mapping[str, str], missing: int, used: list[float]) -> str:
    """Return what was seen in a minute, as a row of the table."""
    return (f'{minute:>6}{float(controller["rate [Hz]"]):>15.1f}'
            f'{float(controller["latency from the stamp [ms]"]):>14.2f}{missing:>6}  '
            + '  '.join(f'{size:>{len(name) + 5}.1f}' for name, size in zip(NAMES, used)))


def main() -> int:
    """Run, print a line every minute, and return 1 if something got lost or grew."""
    known = parser(__doc__)
    known.add_argument('minutes', nargs='?', type=int, default=10)
    asked = known.parse_args()
    rate, span, minutes = TINY if asked.quick else (RATE, MINUTE, asked.minutes)
    with own_domain(), tempfile.TemporaryDirectory() as folder, nodes(
            ('hda_arm_sim.main', f'rate:={rate}'),
            ('hda_torque_estimator.estimating.estimator_node',),
            ('hda_torque_estimator.controlling.controller_node', *CONTROL),
            ('hda_torque_estimator.recording.recorder_node', f'output:={folder}/bag')) as running:
        listener = Listener()
        listener.until(lambda: len(listener.last) == len(NAMES), 'the nodes')
        listener.spin(2.0)
        begin, used = lost(listener), []
        print('minute  commands [Hz]  latency [ms]  lost  ' + '  '.join(
            f'{name} [MB]' for name in NAMES))
        for minute in range(1, minutes + 1):
            listener.spin(span)
            used.append([memory(process.pid) for process in running])
            print(row(minute, listener.last['jtf_controller'], lost(listener) - begin, used[-1]))
        missing = lost(listener) - begin
        listener.close()
    grown = max(last / first for first, last in zip(used[0], used[-1]))
    kept = missing == 0 and grown <= GROWTH
    return verdict(f'{missing} lost; memory grew to {grown:.2f} times that after the first minute',
                   kept, quick=asked.quick, words=('well', 'NOT WELL'))


if __name__ == '__main__':
    sys.exit(main())
