"""Write expected.csv: least squares of the tables beside this file, with 60 digits.

Needs mpmath and, to compare with, statsmodels: `python expected.py`. The first column of a table is
the target, all others are regressors with an intercept; columns in FACTORS are factors whose base is
the least level. statsmodels must agree to the digits that QR in double precision leaves.
"""

import csv
from pathlib import Path

import mpmath
import numpy as np
import statsmodels.api as sm

mpmath.mp.dps = 60
HERE = Path(__file__).parent
FACTORS = {"iris": ["species"], "mtcars": ["cyl"]}
SETS = ["ccard", "copper", "diabetes", "engel", "iris", "mtcars", "scotland", "stackloss"]


def tail(f, numerator, denominator):
    """Return the probability of an F statistic as large or larger."""
    x = denominator / (denominator + numerator * f)
    a, b = mpmath.mpf(denominator) / 2, mpmath.mpf(numerator) / 2
    return mpmath.betainc(a, b, 0, x, regularized=True)


def table(name):
    """Return the names and the columns of the design, with the intercept first, and the target."""
    with (HERE / f"{name}.csv").open() as file:
        header, *rows = list(csv.reader(file))
    columns = {title: [float(row[j]) for row in rows] for j, title in enumerate(header)}
    target = columns.pop(header[0])
    names, design = ["intercept"], [[1.0] * len(rows)]
    for title, values in columns.items():
        if title not in FACTORS.get(name, []):
            names.append(title)
            design.append(values)
            continue
        for level in sorted(set(values))[1:]:
            names.append(f"{title}[{level:g}]")
            design.append([float(value == level) for value in values])
    return names, design, target


def main():
    lines = []
    for name in SETS:
        names, design, target = table(name)
        a = mpmath.matrix([[mpmath.mpf(x) for x in row] for row in zip(*design)])
        b = mpmath.matrix([mpmath.mpf(y) for y in target])
        m, p = a.rows, a.cols
        inverse = (a.T * a) ** -1
        x = inverse * (a.T * b)
        residual = b - a * x
        square = (residual.T * residual)[0]
        freedom = m - p
        mean = sum(b) / m
        total = sum((y - mean) ** 2 for y in b)
        variance = square / freedom
        theirs = sm.OLS(np.array(target), np.array(design).T).fit()
        for j, title in enumerate(names):
            error = mpmath.sqrt(variance * inverse[j, j])
            p_value = tail((x[j] / error) ** 2, 1, freedom)
            found = [float(v) for v in (x[j], error, p_value)]
            others = [theirs.params[j], theirs.bse[j], theirs.pvalues[j]]
            assert np.allclose(found, others, rtol=1e-6), (name, title, found, others)
            lines.append([name, title, *map(repr, found)])
        f = (total - square) / (p - 1) / variance
        found = [float(v) for v in (1 - square / total, f, tail(f, p - 1, freedom))]
        others = [theirs.rsquared, theirs.fvalue, theirs.f_pvalue]
        assert np.allclose(found, others, rtol=1e-6), (name, found, others)
        lines.append([name, "F", *map(repr, found)])
    with (HERE / "expected.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["set", "term", "value or R^2", "error or F", "p"])
        writer.writerows(lines)


if __name__ == "__main__":
    main()
