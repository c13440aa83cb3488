"""Least squares, principal components and singular values from one A^T A."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _catamaran
from ._factors import Levels, coded, indicators, levels_of, refuse_other_factors
from ._frames import columns_of, names_of, refuse_other_rows
from ._options import Progress, callback, is_sparse, matrix_of, rows_of, to_nearest
from ._show import axes, table
from ._words import MissingRows, RankDeficiency

__all__ = ["SVD", "LeastSquares", "PrincipalComponents", "lstsq", "pca", "svd"]


def fit_options(
    ridge: float,
    intercept: bool,
    rank_deficiency: RankDeficiency,
    standard_errors: bool,
    threads: Optional[int],
) -> Dict[str, Any]:
    """Returns options of least squares as the extension takes them."""
    return {
        "ridge": ridge,
        "intercept": intercept,
        "rank_deficiency": rank_deficiency,
        "standard_errors": standard_errors,
        "threads": threads,
    }


@dataclass(frozen=True, repr=False, eq=False)
class LeastSquares:
    """A solution of `lstsq`. With a vector `b` the attributes without a number of targets in their
    shape are numbers, and `x` is a vector."""

    #: The coefficients, n x k.
    x: NDArray[np.float64]
    #: What rounding took from the coefficients, n x k.
    x_low: NDArray[np.float64]
    #: The constant of each target; zeros unless it was asked for.
    intercept: Any
    #: ``|A x - b|`` for each target.
    residual_norm: Any
    #: ``1 - |A x - b|^2 / |b|^2``, about the mean with an intercept.
    r_squared: Any
    #: ``r_squared``, adjusted for the number of coefficients.
    adjusted_r_squared: Any
    #: The standard deviation of the residuals: their norm over the root of `degrees_of_freedom`.
    residual_deviation: Any
    #: The F statistic that all coefficients but the intercept are 0, with `rank` and
    #: `degrees_of_freedom` degrees of freedom; NaN with a ridge.
    f_statistic: Any
    #: The p value of the F statistic.
    f_p_value: Any
    #: The standard error of each coefficient, n x k; empty when not asked for.
    standard_errors: NDArray[np.float64]
    #: The t statistic and the p value (two-sided) of each coefficient, n x k; empty when standard
    #: errors were not asked for.
    t_statistics: NDArray[np.float64]
    p_values: NDArray[np.float64]
    #: The standard error, the t statistic and the p value of each intercept.
    intercept_errors: Any
    intercept_t_statistics: Any
    intercept_p_values: Any
    #: F^T, rank x n, where F F^T is the covariance of `x` when residuals have variance 1; empty
    #: when standard errors were not asked for.
    root: NDArray[np.float64]
    #: The mean of the columns and the sum of the weights with an intercept; else zeros and
    #: infinity.
    mean: NDArray[np.float64]
    weight: float
    #: Columns of A that do not depend on others, as far as the precision can tell.
    rank: int
    #: The other columns.
    dependent: NDArray[np.uintp]
    #: Estimate of the condition number of A.
    condition: float
    #: Rows whose weight is not 0.
    observations: int
    #: Observations less the rank, and less one more with an intercept.
    degrees_of_freedom: int
    #: Decimal digits of the coefficients that agree with the exact solution, from 0 to 15.95.
    digits: float
    #: The names of the columns that factors became, which follow those of `a`; empty without
    #: factors.
    factor_columns: Tuple[str, ...] = ()
    #: The name of each factor and its levels in the rows that were used, the first of which has no
    #: column.
    factor_levels: Levels = ()
    #: The rows that were left out because a value is missing.
    left_out: Tuple[int, ...] = ()
    #: The names of the columns of `a`, if it is a data frame; empty otherwise.
    feature_names: Tuple[str, ...] = ()

    def plot(self, ax: Any = None, confidence: float = 0.95) -> Any:
        """Draws the coefficients with their confidence intervals, by matplotlib."""
        ax = axes(ax)
        x = np.atleast_2d(self.x.T)
        width = np.zeros_like(x)
        if np.size(self.standard_errors) > 0:
            width = np.atleast_2d(self._factor(confidence) * self.standard_errors.T)
        for target, (center, half) in enumerate(zip(x, width)):
            ax.errorbar(np.arange(len(center)), center, half, fmt="o", label=f"target {target}")
        ax.set(xlabel="column", ylabel="coefficient")
        if len(x) > 1:
            ax.legend()
        return ax

    def __repr__(self) -> str:
        return f"LeastSquares({self.observations} observations, rank {self.rank})"

    def _rows(self, target: int, values: Any, constant: Any) -> List[float]:
        """Returns the values of a target, that of the intercept first if there is one."""
        of_target = np.atleast_2d(np.transpose(values))[target]
        return [*np.ravel(constant)[target : target + 1], *of_target]

    def __str__(self) -> str:
        first = len(self.x) - len(self.factor_columns)
        names = list(self.feature_names or map(str, range(first))) + list(self.factor_columns)
        # The weight is that of errors, which may not have been asked for.
        fitted = np.isfinite(self.weight) or np.any(np.asarray(self.intercept) != 0)
        lines = [
            f"{self.observations} observations, rank {self.rank}, {self.degrees_of_freedom} "
            f"degrees of freedom, {self.digits:.1f} digits"
        ]
        shares = np.ravel(self.r_squared)
        for target, share in enumerate(shares):
            columns: Dict[str, Any] = {
                "column": ["intercept"] * int(fitted) + names,
                "coefficient": self._rows(target, self.x, self.intercept if fitted else ()),
            }
            if np.size(self.standard_errors) > 0:
                for name, values, constant in [
                    ("standard error", self.standard_errors, self.intercept_errors),
                    ("t", self.t_statistics, self.intercept_t_statistics),
                    ("p", self.p_values, self.intercept_p_values),
                ]:
                    columns[name] = self._rows(target, values, constant)
            heading = f"target {target}: " if len(shares) > 1 else ""
            lines.append(f"{heading}R^2 {share:.6g}\n{table(columns)}")
        return "\n".join(lines)

    @to_nearest
    def predict(
        self, a: ArrayLike, *, factors: Optional[Mapping[str, Any]] = None
    ) -> NDArray[np.float64]:
        """Predicts the targets of rows, ``A x + intercept``.

        Parameters
        ----------
        a : array_like, m x n, or a matrix of scipy.sparse
            The rows. After a fit of a data frame, columns of a data frame are taken by their names,
            and may be more than those.
        factors : mapping of names to vectors of m labels, optional
            The labels of the rows, after a fit with factors; a prediction without a label is NaN.
            Without them A has the columns `factor_columns`, too.

        Raises
        ------
        ValueError
            Names a column that is missing, a label that the fit does not know, or the number of
            columns.

        Examples
        --------
        >>> import numpy as np
        >>> import catamaran
        >>> age, where = np.arange(5.0)[:, None], ["East", "West", "West", "East", "West"]
        >>> fit = catamaran.lstsq(age, age[:, 0], intercept=True, factors={"region": where})
        >>> fit.predict([[7.0]], factors={"region": ["West"]}).round(12)
        array([7.])
        """
        found: NDArray[np.float64] = self._design(a, factors) @ self.x + self.intercept
        return found

    @to_nearest
    def confidence_intervals(
        self, confidence: float = 0.95
    ) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Returns the ends of the intervals that contain each coefficient with this confidence."""
        self._check_errors()
        width = self._factor(confidence) * self.standard_errors
        return self.x - width, self.x + width

    @to_nearest
    def intercept_intervals(self, confidence: float = 0.95) -> Tuple[Any, Any]:
        """Returns the ends of the interval that contains each intercept with this confidence."""
        self._check_errors()
        width = self._factor(confidence) * self.intercept_errors
        if np.size(width) == 0:
            raise ValueError("intercept_intervals: no intercept was fitted")
        return self.intercept - width, self.intercept + width

    @to_nearest
    def covariance(self, target: int = 0) -> NDArray[np.float64]:
        """Returns the covariance of the coefficients of a target, the intercept first if there is
        one."""
        self._check_errors()
        root: Any = self.root
        if np.isfinite(self.weight):
            root = np.column_stack([-(root @ self.mean), root])
        found: NDArray[np.float64] = root.T @ root
        if np.isfinite(self.weight):
            found[0, 0] += 1 / self.weight
        found *= float(np.atleast_1d(self.residual_deviation)[target]) ** 2
        return found

    @to_nearest
    def prediction_errors(
        self,
        a: ArrayLike,
        *,
        observation: bool = False,
        factors: Optional[Mapping[str, Any]] = None,
    ) -> Any:
        """Returns the standard errors of predictions: of the mean at each row, or with
        `observation` of one new observation there. Rows are given as in `predict`."""
        self._check_errors()
        design = self._design(a, factors)
        if is_sparse(design):
            design = design.toarray()
        spread: Any = (design - self.mean) @ self.root.T
        squares = (spread**2).sum(axis=1) + 1 / self.weight + float(observation)
        return np.multiply.outer(np.sqrt(squares), self.residual_deviation)

    @to_nearest
    def prediction_intervals(
        self,
        a: ArrayLike,
        confidence: float = 0.95,
        *,
        observation: bool = False,
        factors: Optional[Mapping[str, Any]] = None,
    ) -> Tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Returns the ends of the intervals that contain the mean at each row, or with
        `observation` one new observation there, with this confidence. Rows are given as in
        `predict`."""
        errors = self.prediction_errors(a, observation=observation, factors=factors)
        width = self._factor(confidence) * errors
        found = self.predict(a, factors=factors)
        return found - width, found + width

    def _design(self, a: Any, factors: Optional[Mapping[str, Any]]) -> Any:
        """Returns rows with a column for each coefficient, one after the other in memory: by
        columns the products of numpy would differ in their last bits."""
        names, wanted, hint = self.feature_names, len(self.x), ""
        if factors is not None:
            wanted -= len(self.factor_columns)
        elif self.factor_levels:
            those = ", ".join(name for name, _ in self.factor_levels)
            hint = f"; the labels of {those} go to factors"
            own = names_of(a)
            if names and own and not set(self.factor_columns) <= set(own):
                raise ValueError(f"a: has no column {self.factor_columns[0]}{hint}")
            names += self.factor_columns if names else ()
        rows = matrix_of("a", columns_of("a", a, names) if names else a)
        # One row may be a vector.
        shape = np.shape(rows) if not is_sparse(rows) else rows.shape
        if len(shape) not in (1, 2) or shape[-1] != wanted or len(shape) == 1 and factors:
            raise ValueError(f"a: expected m x {wanted}, got {' x '.join(map(str, shape))}{hint}")
        if factors is None:
            return rows if is_sparse(rows) else np.ascontiguousarray(rows)
        columns = indicators(self.factor_levels, factors, rows.shape[0])
        refuse_other_factors(a, factors)
        if is_sparse(rows):
            from scipy.sparse import hstack

            return hstack([rows, columns], format="csr")
        return np.ascontiguousarray(np.hstack([rows, columns]))

    def _factor(self, confidence: float) -> float:
        if not 0 < confidence < 1:
            raise ValueError(f"confidence: must be above 0 and below 1, is {confidence}")
        return _catamaran.t_quantile(1 - confidence, self.degrees_of_freedom)

    def _check_errors(self) -> None:
        if np.size(self.standard_errors) == 0 and np.size(self.x) > 0:
            raise ValueError("standard_errors: were not requested")


def solution(found: Dict[str, Any], one_target: bool) -> LeastSquares:
    """Returns a solution of the extension."""
    if one_target:
        for name in ("x", "x_low", "standard_errors", "t_statistics", "p_values"):
            found[name] = found[name][:, 0] if found[name].size else found[name].ravel()
        for name in OF_TARGETS:
            found[name] = found[name][0] if found[name].size else found[name]
    return LeastSquares(**found)


#: Attributes with a number for each target.
OF_TARGETS = (
    "intercept",
    "residual_norm",
    "r_squared",
    "adjusted_r_squared",
    "residual_deviation",
    "f_statistic",
    "f_p_value",
    "intercept_errors",
    "intercept_t_statistics",
    "intercept_p_values",
)


def lstsq(
    a: ArrayLike,
    b: ArrayLike,
    *,
    weights: Optional[ArrayLike] = None,
    ridge: float = 0.0,
    intercept: bool = False,
    rank_deficiency: RankDeficiency = "minimum_norm",
    standard_errors: bool = True,
    factors: Optional[Mapping[str, Any]] = None,
    missing: MissingRows = "error",
    threads: Optional[int] = None,
    progress: Progress = None,
    comm: Any = None,
) -> LeastSquares:
    """Solves ``min |W^(1/2) (A X - B)|^2 + ridge |X|^2`` in one pass over the rows.

    The Gram matrix of ``[A B]`` is formed in extended precision (159 bits), so that the solution
    is at least as accurate as by an orthogonal factorization of A in float64.

    Parameters
    ----------
    a : array_like, m x n, or a matrix of scipy.sparse
        The matrix A. float32 and float64 are not copied.
    b : array_like of m numbers, or m x k
        The targets B.
    weights : array_like of m numbers, optional
        The diagonal of W, none of them negative.
    ridge : float
        What ``|X|^2`` is multiplied by; the intercept is not a part of X.
    intercept : bool
        Whether a constant is fitted too.
    rank_deficiency : {"minimum_norm", "refuse"}
        What happens when columns of A depend on others: of all solutions the one of least norm, or
        a ValueError that names the columns.
    standard_errors : bool
        Whether they are computed, with p values and what depends on them, which takes a few times
        as long as the solution.
    factors : mapping of names to vectors of m labels, optional
        Columns of categories, which follow those of `a`. Each becomes one column for each of its
        levels but the first, 1 in the rows of that level and 0 elsewhere; levels are sorted, those
        of a pandas categorical keep their order. See `LeastSquares.factor_columns`.
    missing : {"error", "drop"}
        What happens to rows with a NaN, or without a label: a ValueError, or they are left out.
        The "nan" of `read` is refused: no solution can be computed with NaN.
    threads, progress
        As in `ata`.
    comm : communicator of mpi4py, optional
        Every rank of it has some rows of dense A and B, and their weights, and gets the solution
        for all rows: the same bytes for any number of ranks. Rank 0 solves. Without `factors` and
        ``missing="drop"``.

    Returns
    -------
    LeastSquares

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> t = np.arange(5.0)
    >>> found = catamaran.lstsq(t[:, None], 2 * t + 1, intercept=True)
    >>> float(found.x[0]), float(found.intercept), found.rank
    (2.0, 1.0, 1)

    A factor, and a row without a label:

    >>> region = ["East", "West", None, "West", "East"]
    >>> found = catamaran.lstsq(
    ...     t[:, None], t, intercept=True, factors={"region": region}, missing="drop"
    ... )
    >>> found.factor_columns, found.left_out, found.observations
    (('region[West]',), (2,), 4)
    """
    if missing not in ("error", "drop"):
        raise ValueError(f"missing: '{missing}' is not one of 'error', 'drop'")
    options = fit_options(ridge, intercept, rank_deficiency, standard_errors, threads)
    if comm is not None:
        from ._ranks import of_first, sums

        if factors or missing != "error":
            raise ValueError("comm: not together with factors or missing")
        more: Dict[str, Any] = {"threads": threads, "progress": progress}
        total = sums(comm, a, b, weights, "extended", intercept, None, more)
        one = np.ndim(b) == 1
        targets = 1 if one else np.shape(b)[1]
        fit: LeastSquares = of_first(comm, lambda: solution(total._lstsq(targets, options), one))
        return replace(fit, feature_names=names_of(a))
    refuse_other_rows(a, b=b, weights=weights)
    if not factors and missing == "error":
        found = _catamaran.lstsq(rows_of("a", a), b, weights, options, callback(progress))
        found.update(feature_names=names_of(a))
        return solution(found, np.ndim(b) == 1)
    b = matrix_of("b", b)
    levels, codes = coded(factors or {})
    refuse_other_factors(a, factors or {})
    if codes is None:
        codes = np.empty((np.shape(b)[0], 0))
    found, columns, left_out = _catamaran.lstsq_table(
        rows_of("a", a), codes, levels, b, weights, missing == "drop", options, callback(progress)
    )
    if len(left_out) == len(codes) > 0:
        raise ValueError(f"missing: a value is missing in each of {len(codes)} rows: none is left")
    found.update(
        factor_columns=tuple(columns),
        factor_levels=levels_of(levels, np.delete(codes, left_out, axis=0), columns),
        left_out=tuple(left_out),
        feature_names=names_of(a),
    )
    return solution(found, np.ndim(b) == 1)


@dataclass(frozen=True, repr=False, eq=False)
class PrincipalComponents:
    """Principal components of `pca`."""

    #: count x n: one orthonormal row for each component, the most variance first.
    components: NDArray[np.float64]
    #: The variance along each component.
    explained_variance: NDArray[np.float64]
    #: Its share of all variance.
    explained_variance_ratio: NDArray[np.float64]
    #: The singular values of the centred (and standardized) rows.
    singular_values: NDArray[np.float64]
    #: What is subtracted from each column.
    mean: NDArray[np.float64]
    #: What each column is then divided by.
    scale: NDArray[np.float64]
    #: Whether scores have variance 1.
    whiten: bool
    #: The names of the columns, if the rows were a data frame; empty otherwise.
    feature_names: Tuple[str, ...] = ()

    def transform(self, rows: ArrayLike, *, progress: Progress = None) -> NDArray[np.float64]:
        """Returns the scores (m x count) of rows (m x n), which may be a matrix of scipy.sparse, or
        a data frame: after one of a data frame, its columns are taken by their names."""
        if self.feature_names:
            rows = columns_of("rows", rows, self.feature_names)
        return _catamaran.scores(rows_of("rows", rows), self, callback(progress))

    @to_nearest
    def inverse_transform(self, scores: ArrayLike) -> NDArray[np.float64]:
        """Returns the rows (m x n) whose scores these are (m x count), in the space of the
        components."""
        of: Any = matrix_of("scores", scores)
        if self.whiten:
            of = of * np.sqrt(self.explained_variance)
        rows: NDArray[np.float64] = of @ self.components
        rows *= self.scale
        rows += self.mean
        return rows

    def plot(self, ax: Any = None) -> Any:
        """Draws the share of the variance of each component, and their sums, by matplotlib."""
        ax = axes(ax)
        numbers = np.arange(1, len(self.explained_variance) + 1)
        ax.bar(numbers, self.explained_variance_ratio, label="share")
        ax.plot(numbers, self.explained_variance_ratio.cumsum(), "k.-", label="sum")
        ax.set(xlabel="component", ylabel="share of the variance")
        ax.legend()
        return ax

    def __str__(self) -> str:
        shares = self.explained_variance_ratio
        columns: Dict[str, Any] = {
            "component": range(1, len(shares) + 1),
            "variance": self.explained_variance,
            "share": shares,
            "sum of shares": shares.cumsum(),
        }
        return f"{self!r}\n{table(columns)}"

    def __repr__(self) -> str:
        count, n = self.components.shape
        share = float(self.explained_variance_ratio.sum())
        return f"PrincipalComponents({count} of {n} columns, {share:.1%} of the variance)"


def pca(
    a: ArrayLike,
    n_components: Union[int, float, None] = None,
    *,
    weights: Optional[ArrayLike] = None,
    standardize: bool = False,
    whiten: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
    comm: Any = None,
) -> PrincipalComponents:
    """Computes the principal components of the rows of `a`, in one pass over them.

    Parameters
    ----------
    a : array_like, m x n, or a matrix of scipy.sparse
        A row for each observation.
    n_components : int or float, optional
        How many components, or the share of the variance that they explain; all by default.
    weights : array_like of m numbers, optional
        How often each row counts.
    standardize : bool
        Whether columns are divided by their standard deviation.
    whiten : bool
        Whether scores are divided by the root of the variance that they explain.
    threads, progress
        As in `ata`.
    comm : communicator of mpi4py, optional
        Every rank of it has some rows of a dense `a`, and their weights, and gets the components of
        all rows: the same bytes for any number of ranks. Rank 0 computes them.

    Returns
    -------
    PrincipalComponents

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> found = catamaran.pca(np.array([[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]]))
    >>> found
    PrincipalComponents(1 of 2 columns, 100.0% of the variance)
    >>> found.mean
    array([2., 4.])
    >>> print(found)
    PrincipalComponents(1 of 2 columns, 100.0% of the variance)
    component  variance  share  sum of shares
            1         5      1              1
    """
    if comm is not None:
        from ._ranks import of_first, sums

        more: Dict[str, Any] = {"threads": threads, "progress": progress}
        total = sums(comm, a, None, weights, "extended", True, None, more)
        about = {"standardize": standardize, "whiten": whiten, "threads": threads}
        of_all: PrincipalComponents = of_first(comm, lambda: total.pca(n_components, **about))
        return replace(of_all, feature_names=names_of(a))
    refuse_other_rows(a, weights=weights)
    found = _catamaran.pca(
        rows_of("a", a), weights, n_components, standardize, whiten, threads, callback(progress)
    )
    return PrincipalComponents(**found, feature_names=names_of(a))


class SVD(NamedTuple):
    """Singular values and vectors of `svd`."""

    #: m x rank, or None when not asked for.
    u: Optional[NDArray[np.float64]]
    #: n values, descending; zeros where columns depend on others.
    s: NDArray[np.float64]
    #: rank x n: right singular vectors.
    vh: NDArray[np.float64]


@to_nearest
def svd(
    a: ArrayLike,
    *,
    compute_u: bool = False,
    threads: Optional[int] = None,
    progress: Progress = None,
) -> SVD:
    """Computes the singular values and vectors of a tall matrix in one pass over its rows.

    Small singular values have as many digits as large ones, as long as the condition number of A
    with columns of norm 1 is below 2^48 or so.

    Parameters
    ----------
    a : array_like, m x n, or a matrix of scipy.sparse
        The matrix.
    compute_u : bool
        Whether left singular vectors are computed in a second pass, ``A V / s``. They are
        orthogonal up to about 2^-53 times the largest value over the value of each.
    threads, progress
        As in `ata`.

    Returns
    -------
    SVD
        ``u`` (None without `compute_u`), ``s``, ``vh``.

    Examples
    --------
    >>> import numpy as np
    >>> import catamaran
    >>> catamaran.svd(np.array([[3.0, 0.0], [0.0, 1e-9], [0.0, 0.0]])).s
    array([3.e+00, 1.e-09])
    """
    s, v = _catamaran.svd(rows_of("a", a), threads, callback(progress))
    u = None
    if compute_u:
        u = matrix_of("a", a) @ v
        u /= s[: v.shape[1]]
    return SVD(u, s, v.T)
