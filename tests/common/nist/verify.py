"""Recomputes the certified values of the data sets beside it by exact rational arithmetic.

    verify.py            fails if a certified value differs from the exact one in its printed digits
    verify.py --write    also writes rounded.csv, below

NIST certifies the least-squares solution of the decimal numbers in the data. A program gets numbers
of 53 bits instead: y and x rounded, and columns x^k rounded (here by repeated multiplication from
the left). rounded.csv has the exact solution of that problem, which no program that is given these
columns can be expected to beat. For filip it agrees with the certified values in 7.9 digits only;
with columns that are the exact powers of the rounded x it would be 14.0.
"""

import csv
import sys
from decimal import Decimal, getcontext
from fractions import Fraction
from pathlib import Path

getcontext().prec = 80
FOLDER = Path(__file__).parent

HEADER = """# The exact solution, to 25 digits, of the problems with entries rounded to f64:
# x^k = x^(k-1) * x in f64. Written by verify.py.
set,term,coefficient,deviation"""


def table(name):
    """The lines of a file as dictionaries; lines with # are comments."""
    with open(FOLDER / f"{name}.csv") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def columns(rows, degree, intercept, number, rounded):
    """Responses, and the design matrix by rows."""
    y = [number(row["y"]) for row in rows]
    design = []
    for row in rows:
        if degree == 0:
            powers = [number(value) for key, value in row.items() if key != "y"]
        else:
            x = number(row["x"])
            powers = [x]
            while len(powers) < degree:
                powers.append(rounded(powers[-1] * x))
        design.append([Fraction(1)] * intercept + powers)
    return y, design


def solve(y, design):
    """Coefficients, the diagonal of the inverse Gram matrix, and the residual sum of squares."""
    n = len(design[0])
    gram = [
        [sum(row[i] * row[j] for row in design) for j in range(n)]
        + [sum(row[i] * v for row, v in zip(design, y))]
        + [Fraction(i == j) for j in range(n)]
        for i in range(n)
    ]
    for k in range(n):
        pivot = gram[k][k]
        gram[k] = [value / pivot for value in gram[k]]
        for i in range(n):
            if i != k:
                factor = gram[i][k]
                gram[i] = [a - factor * b for a, b in zip(gram[i], gram[k])]
    b = [row[n] for row in gram]
    residuals = [v - sum(x * c for x, c in zip(row, b)) for row, v in zip(design, y)]
    return b, [gram[i][n + 1 + i] for i in range(n)], sum(r * r for r in residuals)


def decimal(value):
    return Decimal(value.numerator) / Decimal(value.denominator)


def digits(value, count):
    return f"{value:.{count - 1}E}" if value else "0"


def statistics(y, design, intercept):
    """Coefficients, their deviations, the residual deviation, and R^2."""
    b, inverse, residual = solve(y, design)
    variance = residual / (len(y) - len(b))
    mean = sum(y) / len(y) if intercept else 0
    total = sum((v - mean) ** 2 for v in y)
    deviations = [decimal(variance * d).sqrt() for d in inverse]
    r_squared = decimal(1 - residual / total)
    return [decimal(c) for c in b], deviations, decimal(variance).sqrt(), r_squared


def same(exact, certified):
    """Whether the certified value is the exact one, rounded to the digits that it has."""
    shown = certified.split("E")[0].replace(".", "").lstrip("-0")
    if not shown:
        return exact == 0
    return digits(exact, len(shown)) == digits(Decimal(certified), len(shown))


def main():
    certified, checked, different, lines = table("certified"), 0, 0, []
    for entry in table("sets"):
        name, degree, intercept = entry["set"], int(entry["degree"]), entry["intercept"] == "1"
        rows = table(name)
        assert len(rows) == int(entry["rows"]), name
        exact = columns(rows, degree, intercept, Fraction, lambda value: value)
        b, deviations, residual, r_squared = statistics(*exact, intercept)
        terms = [line for line in certified if line["set"] == name]
        assert len(terms) == len(b), name
        pairs = [
            (f"{name} residual", residual, entry["residual_deviation"]),
            (f"{name} R^2", r_squared, entry["r_squared"]),
        ]
        for term, coefficient, deviation in zip(terms, b, deviations):
            pairs.append((f"{name} {term['term']}", coefficient, term["coefficient"]))
            pairs.append((f"{name} s({term['term']})", deviation, term["deviation"]))
        for what, value, printed in pairs:
            checked += 1
            if not same(value, printed):
                different += 1
                print(f"{what}: {printed}, exactly {digits(value, 20)}")
        to_double = lambda text: Fraction(float(text))
        problem = columns(rows, degree, intercept, to_double, lambda value: Fraction(float(value)))
        values = statistics(*problem, intercept)
        for term, value, deviation in zip(terms, *values[:2]):
            lines.append(f"{name},{term['term']},{digits(value, 25)},{digits(deviation, 25)}")
    print(f"{checked} certified values, {different} different")
    if "--write" in sys.argv[1:]:
        with open(FOLDER / "rounded.csv", "w") as file:
            print(HEADER, *lines, sep="\n", file=file)
    return different > 0


if __name__ == "__main__":
    sys.exit(main())
