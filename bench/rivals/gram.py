"""What people do with A^T A, by numpy, scipy, statsmodels and scikit-learn; matrices are .npy files.

    gram.py digits FOLDER METHOD      solves min |A x - b| for each NAME-a and NAME-b of FOLDER; writes NAME-METHOD
    gram.py lstsq FOLDER METHOD       solves the problem a, b; writes x-METHOD
    gram.py reference FOLDER          writes x: the solution of a, b, refined with residuals in long double
    gram.py sigma FOLDER METHOD       writes sigma-METHOD: the singular values of a, the largest first
    gram.py pca FOLDER METHOD         writes variances-METHOD: the explained variances of a, the largest first
    gram.py qr FOLDER METHOD          writes q-METHOD: an orthonormal basis of the columns of a

Each prints seconds and bytes of the call alone; those of pca include reading a. Methods are the keys of the tables
below. A method that finds no solution writes NaN.
"""

import glob
import sys
import time

import numpy as np


def memory(key):
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) << 10 for line in status if line.startswith(key))


def measured(call):
    """The result, seconds, and bytes at the peak beside those before."""
    with open("/proc/self/clear_refs", "w") as peak:
        peak.write("5")
    before = memory("VmRSS:")
    start = time.perf_counter()
    result = call()
    seconds = time.perf_counter() - start
    return result, seconds, memory("VmHWM:") - before


def scipy_lstsq(a, b):
    from scipy.linalg import lstsq

    return lstsq(a, b, lapack_driver="gelsy", check_finite=False)[0]


def statsmodels_ols(a, b, method):
    from statsmodels.regression.linear_model import OLS

    return OLS(b, a).fit(method=method).params


LEAST_SQUARES = {
    "numpy-lstsq": lambda a, b: np.linalg.lstsq(a, b)[0],
    "numpy-lstsq-rcond-0": lambda a, b: np.linalg.lstsq(a, b, rcond=0)[0],
    "scipy-gelsy": scipy_lstsq,
    "statsmodels-pinv": lambda a, b: statsmodels_ols(a, b, "pinv"),
    "statsmodels-qr": lambda a, b: statsmodels_ols(a, b, "qr"),
    "numpy-normal-equations": lambda a, b: np.linalg.solve(a.T @ a, a.T @ b),
}


def scipy_gesdd(a):
    from scipy.linalg import svdvals

    return svdvals(a, check_finite=False)


def gram_eigenvalues(a):
    squares = np.linalg.eigvalsh(a.T @ a)[::-1]
    return np.sqrt(np.maximum(squares, 0))


SINGULAR_VALUES = {
    "numpy-gesdd": lambda a: np.linalg.svd(a, compute_uv=False),
    "scipy-gesdd": scipy_gesdd,
    "numpy-eigvalsh-of-gram": gram_eigenvalues,
}


def covariance_eigh(path):
    from sklearn.decomposition import PCA

    return PCA(svd_solver="covariance_eigh").fit(np.load(path)).explained_variance_


def incremental(path):
    from sklearn.decomposition import IncrementalPCA

    m, n = np.load(path, mmap_mode="r").shape
    # IncrementalPCA.fit copies all of a memory map, so that batches of its default size go in by partial_fit.
    batch, pca = 5 * n, IncrementalPCA()
    # The last batch may not have fewer rows than components.
    starts = range(0, max(m - n, 1), batch)
    for start in starts:
        end = start + batch if start + batch < m - n else m
        # A new map each time: the pages of an old one would count as memory of the process.
        pca.partial_fit(np.array(np.load(path, mmap_mode="r")[start:end]))
    return pca.explained_variance_


PRINCIPAL_COMPONENTS = {"sklearn-covariance-eigh": covariance_eigh, "sklearn-incremental": incremental}
ORTHONORMAL_BASES = {"numpy-qr": lambda a: np.linalg.qr(a)[0]}


def solution(method, a, b):
    try:
        return LEAST_SQUARES[method](a, b)
    except np.linalg.LinAlgError:
        return np.full(a.shape[1], np.nan)


def residual_and_gradient(a, b, x):
    """b - A x and A^T (b - A x) in long double, by blocks of rows."""
    gradient, norm = np.zeros(a.shape[1], np.longdouble), np.longdouble(0)
    for start in range(0, len(a), 4096):
        rows = a[start : start + 4096].astype(np.longdouble)
        residual = b[start : start + 4096] - rows @ x
        gradient += residual @ rows
        norm += residual @ residual
    return np.sqrt(norm), gradient


def reference(a, b, steps=30):
    """Refines by the normal equations, each step by about cond(A)^2 2^-53, as long as the gradient shrinks."""
    from scipy.linalg import cho_factor, cho_solve

    factor = cho_factor(a.T @ a)
    x, best = np.zeros(a.shape[1], np.longdouble), np.inf
    for _ in range(steps):
        _, gradient = residual_and_gradient(a, b, x)
        step = cho_solve(factor, gradient.astype(np.float64))
        size = np.abs(step).max()
        if size >= best / 2:
            break
        x, best = x + step, size
    return x.astype(np.float64)


def main(task, folder, method=None):
    load = lambda name: np.load(f"{folder}/{name}.npy")
    save = lambda name, values: np.save(f"{folder}/{name}.npy", np.asarray(values, np.float64))
    if task == "digits":
        problems = sorted(path.removesuffix("-a.npy") for path in glob.glob(f"{folder}/*-a.npy"))
        solve = lambda: {p: solution(method, np.load(f"{p}-a.npy"), np.load(f"{p}-b.npy").ravel()) for p in problems}
        solutions, seconds, bytes_ = measured(solve)
        for problem, x in solutions.items():
            np.save(f"{problem}-{method}.npy", x.reshape(-1, 1))
    elif task == "lstsq":
        a, b = load("a"), load("b").ravel()
        # What is imported is not measured.
        solution(method, a[: 2 * a.shape[1]], b[: 2 * a.shape[1]])
        x, seconds, bytes_ = measured(lambda: solution(method, a, b))
        save(f"x-{method}", x.reshape(-1, 1))
    elif task == "reference":
        x, seconds, bytes_ = measured(lambda: reference(load("a"), load("b").ravel()))
        save("x", x.reshape(-1, 1))
    elif task == "sigma":
        a = load("a")
        SINGULAR_VALUES[method](a[:64, :8])
        values, seconds, bytes_ = measured(lambda: SINGULAR_VALUES[method](a))
        save(f"sigma-{method}", values.reshape(-1, 1))
    elif task == "pca":
        import sklearn.decomposition

        values, seconds, bytes_ = measured(lambda: PRINCIPAL_COMPONENTS[method](f"{folder}/a.npy"))
        save(f"variances-{method}", values.reshape(-1, 1))
    elif task == "qr":
        a = load("a")
        q, seconds, bytes_ = measured(lambda: ORTHONORMAL_BASES[method](a))
        save(f"q-{method}", q)
    else:
        sys.exit(f"{task}: unknown")
    print(seconds, bytes_)


main(*sys.argv[1:])
