import sys
from pathlib import Path

# Random trees come from the tests of trees that become tasks.
sys.path.append(str(Path(__file__).parents[1] / "pytrees"))
