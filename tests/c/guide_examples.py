"""Compiles and runs the code of docs/guide/c.md; a comment behind a printf is the line it prints.

    guide_examples.py CXX INCLUDE_DIR LIBRARY [EIGEN_DIR]

Statements become the body of a program. Those of Eigen need its folder, those of Fortran gfortran.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile

PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../docs/guide/c.md")
HEADERS = "#include <catamaran.hpp>\n#include <cstdio>\n"
EIGEN = "#include <catamaran/eigen.hpp>\n#include <Eigen/Dense>\n#include <Eigen/Sparse>\n"
# What the page reads: a scan with a hole.
SCAN = """auto scan = catamaran::shape("icosphere", {4}, {});
catamaran::triangle_list faces(scan.faces().begin() + 4, scan.faces().end());
catamaran::mesh_file({scan.vertices(), faces}).write("scan.ply");
"""


def source(language, code):
    """The file name and the text of a program with this code."""
    if language == "c":
        return "main.c", code
    if language == "fortran":
        first, rest = code.split("\n", 1)
        return "main.f90", f"program main\n{first}\nimplicit none\n{rest}end program\n"
    before = SCAN if "scan.ply" in code else ""
    headers = HEADERS + (EIGEN if "Eigen::" in code else "")
    return "main.cpp", f"{headers}int main()\n{{\n{before}{code}return 0;\n}}\n"


def command(language, code, options):
    """What compiles such a program; none without the compiler or Eigen."""
    cxx, include, library, *eigen = options
    rest = [library, "-Wl,-rpath," + os.path.dirname(library), "-I", include, "-lm", "-o", "main"]
    if language == "fortran":
        module = os.path.join(include, "catamaran.f90")
        return ["gfortran", module, "main.f90", *rest] if shutil.which("gfortran") else None
    if language == "c":
        return [cxx, "-x", "c", "-std=c99", "-Wall", "-Werror", "main.c", "-x", "none", *rest]
    if "Eigen::" in code and not eigen:
        return None
    system = [part for folder in eigen for part in ("-isystem", folder)]
    return [cxx, "-std=c++17", *system, "main.cpp", *rest]


def main():
    options = sys.argv[1:]
    with open(PAGE, encoding="utf-8") as file:
        blocks = re.findall(r"```(c|cpp|fortran)\n(.*?)```", file.read(), re.S)
    assert {language for language, _ in blocks} == {"c", "cpp", "fortran"}
    ran = 0
    for language, code in blocks:
        line = command(language, code, options)
        if line is None:
            continue
        with tempfile.TemporaryDirectory() as folder:
            name, text = source(language, code)
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(text)
            subprocess.run(line, cwd=folder, check=True)
            program = os.path.join(folder, "main")
            done = subprocess.run([program], cwd=folder, check=True, capture_output=True, text=True)
        said = re.findall(r"printf.* // (.*)", code)
        missing = [text for text in said if text not in done.stdout.splitlines()]
        if missing:
            sys.exit(f"not printed: {missing}\nprinted:\n{done.stdout}")
        ran += 1
    print(f"{ran} of {len(blocks)} programs of the guide ran")


main()
