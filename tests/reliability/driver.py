"""Stands in for ``fretsolve run``: writes a result of made-up states, with its options and exit codes.

``driver.py OUT [--resume | --overwrite] [--increments N] [--points N] [--every N] [--hold-at STEP]
[--fail-at STEP]`` prints ``increment STEP`` for each increment as soon as it is saved. In the increment of
``--hold-at`` it prints ``holding`` and waits until the file ``OUT.go`` is there.
"""

from fretsolve.system.signals import EXIT_STOPPED, StopRequest  # before anything heavy

if __name__ == "__main__":
    with StopRequest() as stop:
        import sys
        from pathlib import Path

        sys.path.insert(0, str(Path(__file__).parents[1]))
        import argparse
        import time

        from fake_states import fake_header, fake_states

        from fretsolve.errors import FretsolveError
        from fretsolve.result import HistoryWriter

        parser = argparse.ArgumentParser()
        parser.add_argument("out", type=Path)
        parser.add_argument("--resume", action="store_true")
        parser.add_argument("--overwrite", action="store_true")
        for name, default in (("increments", 6), ("points", 6), ("every", 1), ("fail-at", -1), ("hold-at", -1)):
            parser.add_argument(f"--{name}", type=int, default=default)
        options = parser.parse_args()

        def run() -> int:
            shape = (options.points, options.points)
            header = fake_header(shape, every=options.every, increments=options.increments)
            with HistoryWriter.open(options.out, header, resume=options.resume, overwrite=options.overwrite) as writer:
                if writer.complete:
                    return 0
                for state in fake_states(options.increments, writer.last_state, shape=shape):
                    if state.summary.step == options.fail_at:
                        writer.finish("failed", f"no solution at increment {options.fail_at}")
                        return 3
                    if state.summary.step == options.hold_at:
                        print("holding", flush=True)
                        while not options.out.with_suffix(".h5.go").exists():
                            time.sleep(0.01)
                    writer.append(state)
                    print(f"increment {state.summary.step}", flush=True)
                    if stop.requested:
                        return EXIT_STOPPED
                writer.finish("complete")
            return 0

        try:
            code = run()
        except FretsolveError as error:
            print(error, file=sys.stderr)
            code = error.exit_code
    sys.exit(code)
