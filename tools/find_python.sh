#!/bin/sh
# Prints the Python to use: PYTHON when it is set, else the first of python3, python3.12, python3.11 that is 3.11 or 3.12.
set -u
fits() { "$1" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 12))' 2>/dev/null; }
for candidate in ${PYTHON:-python3 python3.12 python3.11}; do
    if command -v "$candidate" >/dev/null && fits "$candidate"; then
        command -v "$candidate"
        exit 0
    fi
done
echo "GRIP needs Python 3.11 or 3.12 (found: $(${PYTHON:-python3} --version 2>&1)). Install one, or name it: make PYTHON=python3.12" >&2
exit 1
