"""Counts the lines of Rust by folder: python3 docs/measuring/lines_of_code.py [FOLDER...]

Left out: blank lines, comments, files of tests, and a file's tests below `#[cfg(test)] mod`.
"""

import re
import sys
from collections import Counter
from pathlib import Path

FOLDERS = ["protocol", "firmware", "mapping", "captures", "src", "xtask"]
IN_LINE_TESTS = re.compile(r"^#\[cfg\(test\)\]\nmod \w+ \{", re.MULTILINE)


def is_of_tests(path):
    return path.stem == "tests" or {"tests", "testing", "target", "benches", "examples"} & set(path.parts)


def lines(path):
    code = IN_LINE_TESTS.split(path.read_text())[0]
    code = (line.strip() for line in code.splitlines())
    return sum(1 for line in code if line and not line.startswith("//"))


counts = Counter()
for folder in sys.argv[1:] or FOLDERS:
    for path in Path(folder).rglob("*.rs"):
        if not is_of_tests(path):
            inside = path.relative_to(folder).parts
            counts[f"{folder}/{inside[0]}" if len(sys.argv) > 1 and len(inside) > 1 else folder] += lines(path)
for folder, count in counts.most_common():
    print(f"{count:6} {folder}")
print(f"{counts.total():6} in all")
