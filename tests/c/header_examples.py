"""Compiles the examples of catamaran.h, runs them, and compares what they print with what they say.

    header_examples.py COMPILER INCLUDE_DIR LIBRARY

A comment behind a printf is the line that it prints. Those of MPI are compiled alone, where mpicc is.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile

HEADERS = "".join(f"#include <{name}.h>\n" for name in ("math", "stdint", "stdio", "stdlib"))


def examples(header):
    """The names of sections, and the lines of their examples."""
    for section in header.split("@defgroup ")[1:]:
        for code in re.findall(r" \* @code\{\.c\}\n(.*?) \* @endcode", section, re.S):
            yield section.split()[0], [line[3:] for line in code.splitlines()]


def program(include, chosen):
    """One function for each example; those that are functions stand by themselves."""
    source, calls = HEADERS + f"#include <{include}>\n", ""
    for name, lines in chosen:
        body = "\n".join(lines) + "\n"
        if body.startswith("static"):
            source += body
            calls += "(void)" + re.search(r"(\w+)\(", body)[1] + ";\n"
        else:
            source += f"static void example_{name}(void)\n{{\n{body}}}\n"
            calls += f"example_{name}();\n"
    return source + "int main(void)\n{\n" + calls + "return 0;\n}\n"


def compiled(source, folder, include, command):
    path = os.path.join(folder, "examples.c")
    with open(path, "w", encoding="utf-8") as file:
        file.write(source)
    compiler, *rest = command
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-I", include]
    subprocess.run([compiler, *flags, path, *rest], check=True)


def main():
    compiler, include, library = sys.argv[1:]
    with open(os.path.join(include, "catamaran.h"), encoding="utf-8") as file:
        found = list(examples(file.read()))
    of_mpi = [example for example in found if any("MPI_" in line for line in example[1])]
    alone = [example for example in found if example not in of_mpi]
    with tempfile.TemporaryDirectory() as folder:
        binary = os.path.join(folder, "examples")
        rpath = "-Wl,-rpath," + os.path.dirname(library)
        compiled(
            program("catamaran.h", alone), folder, include, [compiler, "-o", binary, library, rpath, "-lm"]
        )
        printed = subprocess.run([binary], check=True, capture_output=True, text=True).stdout
        if shutil.which("mpicc"):
            compiled(program("catamaran_mpi.h", of_mpi), folder, include, ["mpicc", "-fsyntax-only"])
    said = [
        line.split(" // ")[1]
        for _, lines in alone
        for line in lines
        if "printf" in line and " // " in line
    ]
    missing = [line for line in said if line not in printed.splitlines()]
    print(f"{len(found)} examples, {len(said)} lines that they say they print")
    if missing:
        sys.exit(f"not printed: {missing}\nprinted:\n{printed}")


main()
