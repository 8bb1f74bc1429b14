import sys
from pathlib import Path

# Random tasks come from the tests of parity.
sys.path.append(str(Path(__file__).parents[2] / "parity"))
