"""Points the wheels' CMake exports at this virtual environment.

They carry the paths of the machine that built them: Python's headers and numpy's.
"""

import re
import sys
import sysconfig
from pathlib import Path

import numpy

BUILT_IN = r"/opt/python/cp\d+-cp\d+"
PATHS = {
    BUILT_IN + r"/lib/python[\d.]+/site-packages/numpy/_core/include": numpy.get_include(),
    BUILT_IN + r"/include/python[\d.]+": sysconfig.get_paths()["include"],
}

for file in Path(sys.prefix, "share").rglob("*.cmake"):
    text = fixed = file.read_text()
    for pattern, path in PATHS.items():
        fixed = re.sub(pattern, lambda _: path, fixed)
    if fixed != text:
        file.write_text(fixed)
