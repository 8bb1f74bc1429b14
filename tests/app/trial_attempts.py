"""The recorder of attempts that benchmarks measure with."""

import importlib.util
import sys
from pathlib import Path

FILE = Path(__file__).parents[2] / "benchmarks" / "attempts.py"
_spec = importlib.util.spec_from_file_location("attempts", FILE)
attempts = sys.modules["attempts"] = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(attempts)
AttemptRecorder, CHECKS = attempts.AttemptRecorder, attempts.CHECKS
