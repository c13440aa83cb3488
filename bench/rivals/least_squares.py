"""Least squares of public tables by ours, R's lm and statsmodels, beside 60 digits.

    least_squares.py PROGRAM RECORD    fits all tables by the command line PROGRAM; writes RECORD
    least_squares.py --expected        writes what tests compare with: EXPECTED

A target is the first column unless it is named; the other columns that are used are regressors.
Factors are coded by treatment. Rows with a missing cell in a column that is used are left out.
"""

import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import mpmath
import numpy as np

mpmath.mp.dps = 60
TABLES = Path(__file__).parents[2] / "tests/common/tables"
EXPECTED = TABLES / "expected.csv"
CONFIDENCE = 0.95
# Correct digits that count: those of a number in double precision.
MOST = 15
# What `Fit.summary` has, by the names that ours gives it.
SUMMARY = ["r_squared", "adjusted_r_squared", "f_statistic", "residual_deviation"]


class Set(NamedTuple):
    """A table, and what is fitted to it."""

    # tests: a file of TABLES; R: a data set of R; others: packages with data sets.
    source: str
    name: str
    target: str = ""
    # All if there are none.
    regressors: tuple = ()
    # The base of each factor.
    factors: dict = {}
    intercept: bool = True


SETS = [
    Set("tests", "airquality", "Ozone", ("Solar.R", "Wind", "Temp", "Month"), {"Month": "5"}),
    Set("tests", "ccard"),
    Set("tests", "copper"),
    Set("tests", "diabetes"),
    Set("tests", "engel"),
    Set("tests", "iris", factors={"species": "0"}),
    Set("tests", "mtcars", factors={"cyl": "4"}),
    Set("tests", "scotland"),
    Set("tests", "stackloss"),
    Set("tests", "ToothGrowth", "len", factors={"supp": "VC", "dose": "0.5"}),
    Set("tests", "warpbreaks", "breaks", factors={"wool": "A", "tension": "L"}),
    Set("R", "cars", "dist", intercept=False),
    Set("R", "ChickWeight", "weight", ("Time", "Diet"), {"Diet": "1"}),
    Set("R", "CO2", "uptake", ("Type", "conc"), {"Type": "Quebec"}),
    Set("R", "LifeCycleSavings", "sr"),
    Set("R", "longley", "Employed"),
    Set("R", "swiss", "Fertility"),
    Set("statsmodels", "spector", "GRADE"),
    Set("statsmodels", "star98", "NABOVE"),
    Set("sklearn", "diabetes", "target"),
]


class Problem(NamedTuple):
    """A regression: the intercept first, then the columns in the order of the table."""

    names: list
    columns: list
    target: list
    left_out: int


class Fit(NamedTuple):
    """The numbers of a fit, in the order of the columns; `ends` are pairs."""

    values: list
    errors: list
    t: list
    # That of F comes last.
    p: list
    ends: list
    covariance: list
    summary: list


def export(folder):
    """Writes the data sets that are no tables of the tests, as their packages do by default."""
    of = lambda source: [each.name for each in SETS if each.source == source]
    names = ", ".join(f'"{name}"' for name in of("R"))
    one = f'write.csv(get(name), file.path("{folder}", paste0(name, ".csv")))'
    subprocess.run(["Rscript", "-e", f"for (name in c({names})) {one}"], check=True)
    import statsmodels.api as sm
    from sklearn.datasets import load_diabetes

    frames = {name: getattr(sm.datasets, name).load_pandas().data for name in of("statsmodels")}
    frames["diabetes"] = load_diabetes(as_frame=True).frame
    for name, frame in frames.items():
        frame.to_csv(folder / f"{name}.csv", index=False)


def problem_of(each, path):
    """Returns the regression of a set."""
    with path.open() as file:
        header, *rows = list(csv.reader(file))
    target = each.target or header[0]
    # A column without a name numbers the rows.
    regressors = each.regressors or [name for name in header if name not in ("", target)]
    at = [header.index(name) for name in (target, *regressors)]
    complete = [row for row in rows if "NA" not in (row[j] for j in at)]
    response, *columns = [[row[j] for row in complete] for j in at]
    found = {"intercept": [1.0] * len(complete)} if each.intercept else {}
    for name, cells in zip(regressors, columns):
        if name not in each.factors:
            found[name] = [float(cell) for cell in cells]
            continue
        is_number = all(cell.replace(".", "").isdigit() for cell in cells)
        for level in sorted(set(cells), key=float if is_number else str):
            if level != each.factors[name]:
                found[f"{name}[{level}]"] = [float(cell == level) for cell in cells]
    response = [float(cell) for cell in response]
    return Problem(list(found), list(found.values()), response, len(rows) - len(complete))


def tail(f, numerator, denominator):
    """Returns the probability of an F statistic as large or larger."""
    x = denominator / (denominator + numerator * f)
    a, b = mpmath.mpf(denominator) / 2, mpmath.mpf(numerator) / 2
    return mpmath.betainc(a, b, 0, x, regularized=True)


def half_width(freedom):
    """Returns half of a confidence interval, in standard errors."""
    from scipy.stats import t

    missed = lambda x: tail(x * x, 1, freedom) - (1 - mpmath.mpf(CONFIDENCE))
    return mpmath.findroot(missed, t.ppf((1 + CONFIDENCE) / 2, freedom))


def exact(problem, intercept):
    """Returns the fit in 60 digits."""
    a = mpmath.matrix([[mpmath.mpf(x) for x in row] for row in zip(*problem.columns)])
    b = mpmath.matrix([mpmath.mpf(y) for y in problem.target])
    m, n = a.rows, a.cols
    inverse = (a.T * a) ** -1
    x = inverse * (a.T * b)
    square, freedom, regressors = sum(r * r for r in b - a * x), m - n, n - intercept
    mean = sum(b) / m if intercept else 0
    total = sum((y - mean) ** 2 for y in b)
    covariance = inverse * (square / freedom)
    errors = [mpmath.sqrt(covariance[j, j]) for j in range(n)]
    t = [value / error for value, error in zip(x, errors)]
    width = half_width(freedom)
    f = (total - square) / regressors / (square / freedom)
    adjusted = 1 - square / total * (m - intercept) / freedom
    deviation = mpmath.sqrt(square / freedom)
    return Fit(
        list(x),
        errors,
        t,
        [*(tail(value * value, 1, freedom) for value in t), tail(f, regressors, freedom)],
        [x[j] + sign * width * errors[j] for j in range(n) for sign in (-1, 1)],
        list(covariance),
        [1 - square / total, adjusted, f, deviation],
    )


def of_statsmodels(problem):
    """Returns the fit of OLS."""
    import statsmodels.api as sm

    fit = sm.OLS(np.array(problem.target), np.array(problem.columns).T).fit()
    summary = [fit.rsquared, fit.rsquared_adj, fit.fvalue, fit.scale**0.5]
    p = [*fit.pvalues, fit.f_pvalue]
    kinds = [fit.params, fit.bse, fit.tvalues, p, fit.conf_int(1 - CONFIDENCE)]
    return Fit(*(np.ravel(kind).tolist() for kind in (*kinds, fit.cov_params(), summary)))


def of_r(problems, folder):
    """Returns the fits of lm."""
    place = lambda each: folder / f"{each.source}-{each.name}-lm"
    lines = []
    for each, path, problem in problems:
        terms = dict.fromkeys(name.split("[")[0] for name in problem.names if name != "intercept")
        target = each.target or path.read_text().split(",", 1)[0]
        formula = f"{target} ~ {' + '.join(terms)}" + ("" if each.intercept else " - 1")
        factors = ";".join(f"{name}={base}" for name, base in each.factors.items())
        lines.append(f"{path}\t{formula}\t{factors}\t{place(each)}\n")
    script = ["Rscript", Path(__file__).with_suffix(".R")]
    subprocess.run(script, input="".join(lines), text=True, check=True)
    fits = []
    for each, _, problem in problems:
        kinds = dict(line.split(",", 1) for line in place(each).read_text().splitlines())
        names = kinds.pop("names").replace("(Intercept)", "intercept").split(",")
        assert names == [name.translate({91: None, 93: None}) for name in problem.names], names
        fits.append(Fit(*([float(x) for x in kinds[kind].split(",")] for kind in Fit._fields)))
    return fits


def of_ours(program, each, path, problem, output):
    """Returns the fit of the command line, and the condition that it prints."""
    words = [program, "lstsq", path, "--by-column", each.target or "0", "-o", output]
    words += ["--intercept"] if each.intercept else []
    if each.regressors:
        words += ["--columns", ",".join((each.target, *each.regressors))]
    for name, base in each.factors.items():
        words += ["--factor", f"{name}={base}"]
    words += ["--missing", "drop", "--confidence", str(CONFIDENCE), "--covariance"]
    subprocess.run(words, check=True, capture_output=True)
    found = json.loads(output.read_text())
    target = found["targets"][0]
    names = ["intercept"] * each.intercept + found["columns"]
    assert (names, found["left_out"]) == (problem.names, problem.left_out), (each, names)
    first = lambda name: [target[name]] if each.intercept else []
    ends = [first(f"intercept_{end}") + target[end] for end in ("lower", "upper")]
    fit = Fit(
        first("intercept") + target["x"],
        first("intercept_error") + target["standard_error"],
        first("intercept_t") + target["t"],
        first("intercept_p") + target["p"] + [target["f_p"]],
        np.transpose(ends).ravel().tolist(),
        np.ravel(target["covariance"]).tolist(),
        [target[name] for name in SUMMARY],
    )
    return fit, found["condition"]


def digits(found, right):
    """Returns the correct digits of the worst number of each kind."""
    pairs = zip(right.ends[::2], right.ends[1::2])
    scales = right._asdict()
    # An end may be near 0 by chance, a covariance even 0.
    scales["ends"] = [max(abs(low), abs(high)) for low, high in pairs for _ in range(2)]
    scales["covariance"] = [one * other for one in right.errors for other in right.errors]

    def worst(kind):
        numbers = zip(getattr(found, kind), getattr(right, kind), scales[kind], strict=True)
        error = max(abs((x - y) / scale) for x, y, scale in numbers)
        return float(min(MOST, -mpmath.log10(error))) if error else MOST

    return [worst(kind) for kind in Fit._fields]


def write(path, lines):
    with Path(path).open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)


def expected():
    lines = [["set", "term", "value or R^2", "error or F", "p"]]
    for each in SETS:
        if each.source != "tests":
            continue
        problem = problem_of(each, TABLES / f"{each.name}.csv")
        fit = exact(problem, each.intercept)
        r_squared, _, f, _ = fit.summary
        terms = zip(problem.names, fit.values, fit.errors, fit.p)
        for term, *numbers in [*terms, ("F", r_squared, f, fit.p[-1])]:
            lines.append([each.name, term, *(repr(float(x)) for x in numbers)])
    write(EXPECTED, lines)


def main(program, record):
    import statsmodels

    version = ["Rscript", "-e", "cat(as.character(getRversion()))"]
    r = subprocess.run(version, capture_output=True, text=True, check=True).stdout
    contenders = ["ours", f"R {r}", f"statsmodels {statsmodels.__version__}"]
    lines = [["table", "from", "rows", "left_out", "coefficients", "condition", "contender"]]
    lines[0] += Fit._fields
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        export(folder)
        problems = []
        for each in SETS:
            path = (TABLES if each.source == "tests" else folder) / f"{each.name}.csv"
            problems.append((each, path, problem_of(each, path)))
        for (each, path, problem), lm in zip(problems, of_r(problems, folder)):
            right = exact(problem, each.intercept)
            own, condition = of_ours(program, each, path, problem, folder / f"{each.name}.json")
            (folder / f"{each.name}.json").unlink()
            size = [len(problem.target), problem.left_out, len(problem.names), f"{condition:.1e}"]
            for contender, fit in zip(contenders, (own, lm, of_statsmodels(problem))):
                found = [f"{x:.1f}" for x in digits(fit, right)]
                lines.append([each.name, each.source, *size, contender, *found])
                print(*lines[-1])
    write(record, lines)


if __name__ == "__main__":
    expected() if sys.argv[1:] == ["--expected"] else main(*sys.argv[1:])
