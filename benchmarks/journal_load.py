"""The journal under load: cost in the thread that ticks, a million transitions a second for a minute, a live monitor.

    .venv/bin/python benchmarks/journal_load.py [SECONDS]

The cost is CPU time of the ticking thread with an empty loop of calls taken off; both sides of a ratio in turns.
"""

import resource
import statistics
import sys
import tempfile
import threading
import time
from pathlib import Path

from grip_bt.runtime import Journal, JournalReader, WallClock
from grip_bt.runtime.observers import Recorder


class Standing:
    """A clock that costs next to nothing."""

    def now(self):
        return 0.0


PATHS = [f"attempt/part_{n // 10}/step_{n}" for n in range(100)]
RATE = 1_000_000


class Deaf:
    def entered(self, path):
        pass

    def ended(self, path, outcome, failure):
        pass


def round_of(observer):
    """2 transitions at each of 100 nodes."""
    entered, ended = observer.entered, observer.ended
    for path in PATHS:
        entered(path)
        ended(path, "success", None)


def cost(clock):
    """Return the CPU time [ns] of a transition in the ticking thread, and of a call that does nothing."""
    taken = {True: [], False: []}
    with tempfile.TemporaryDirectory() as folder, Journal(Path(folder) / "runs.sqlite") as book:
        sides = {True: Recorder(book.begin("cost"), clock), False: Deaf()}
        for _ in range(300):
            for is_journal, observer in sides.items():
                began = time.thread_time()
                for _ in range(20):
                    round_of(observer)
                taken[is_journal].append((time.thread_time() - began) / (20 * 2 * len(PATHS)))
            time.sleep(0.002)
    return tuple(statistics.median(taken[side]) * 1e9 for side in (True, False))


def sustained(seconds):
    """Append at `RATE` for so long; print whether it kept up, the memory and the file."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "runs.sqlite"
        cpu = time.process_time()
        with Journal(file) as book:
            log = book.begin("load")
            recorder = Recorder(log, WallClock())
            began, done, longest, peaks = time.perf_counter(), 0, 0, []
            while (now := time.perf_counter() - began) < seconds:
                while done < now * RATE:
                    round_of(recorder)
                    done += 2 * len(PATHS)
                longest = max(longest, len(log.buffer) // 4)
                if now > 10 * len(peaks):
                    peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)
                time.sleep(0.0005)
            took = time.perf_counter() - began
            book.flush()
            late = time.perf_counter() - began - took
        with JournalReader(file) as reader:
            count = reader.count(log.id)
            page = reader.events(log.id, count - 1000)
        assert (count, len(page), page[-1].path) == (done, 1000, PATHS[-1])
        cpu = (time.process_time() - cpu) / took
        print(
            f"{done / took / 1e6:.2f} M transitions/s for {took:.0f} s, all there {late * 1e3:.0f} ms after the last;"
            f" at most {longest:,} waiting; peak memory every 10 s {peaks} MiB; {cpu:.2f} cores;"
            f" {file.stat().st_size / done:.2f} bytes each"
        )


def monitored():
    """Return the ticking thread's CPU time [s] a round with and without a viewer that asks thirty times a second."""
    taken = {True: [], False: []}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "runs.sqlite"
        with Journal(file) as book:
            recorder = Recorder(log := book.begin("watched"), WallClock())
            recorder.say("run_started")
            book.flush()
            for turn in range(40):
                seen, done = turn % 2 == 0, threading.Event()
                viewer = threading.Thread(target=watch, args=(file, log.id, done)) if seen else None
                if viewer:
                    viewer.start()
                began = time.thread_time()
                work_until = time.perf_counter() + 0.5
                rounds = 0
                while time.perf_counter() < work_until:
                    round_of(recorder)
                    rounds += 1
                    time.sleep(0.002)  # a tree of 100 nodes at 500 Hz
                taken[seen].append((time.thread_time() - began) / rounds)
                done.set()
                if viewer:
                    viewer.join()
    return taken


def watch(file, run, done):
    with JournalReader(file) as reader:
        seq = reader.count(run)
        while not done.wait(1 / 30):
            for event in reader.events(run, seq, 10_000):
                seq = event.seq


if __name__ == "__main__":
    for title, clock in (("the wall's clock", WallClock()), ("a clock that stands", Standing())):
        journal, nothing = cost(clock)
        print(
            f"{title}: {journal:.0f} ns a transition in the ticking thread, of which {nothing:.0f} are the call itself"
        )
    watched = monitored()
    alone, seen = (statistics.median(watched[side]) for side in (False, True))
    print(
        f"a live monitor: {(seen / alone - 1) * 100:+.1f} % in the ticking thread ({alone * 1e6:.0f} us a round alone)"
    )
    sustained(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)
