"""Estimators for scikit-learn, on top of `catamaran.pca` and `catamaran.lstsq`.

>>> import numpy as np
>>> from catamaran.sklearn import PCA, LinearRegression
>>> x = np.array([[1.0, 2.0], [2.0, 4.0], [3.0, 7.0]])
>>> PCA(n_components=1).fit_transform(x).shape
(3, 1)
>>> float(LinearRegression().fit(x[:, :1], 2 * x[:, 0] + 1).intercept_.round(12))
1.0
"""

from __future__ import annotations

from typing import Any, Optional, Union

import numpy as np
from sklearn.base import (
    BaseEstimator,
    ClassNamePrefixFeaturesOutMixin,
    MultiOutputMixin,
    RegressorMixin,
    TransformerMixin,
)
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from ._distribution import require_own
from ._gram import PrincipalComponents, lstsq, pca
from ._options import to_nearest
from ._products import Accumulator

require_own()

__all__ = ["LinearRegression", "PCA", "Ridge"]

FLOATS = [np.float64, np.float32]

#: Rows that are centred at once.
BLOCK = 4096


class PCA(ClassNamePrefixFeaturesOutMixin, TransformerMixin, BaseEstimator):
    """Principal components, from one pass over the rows in extended precision.

    `partial_fit` takes the rows in batches and sums in float64. No method copies the rows.

    Parameters
    ----------
    n_components : int or float, optional
        How many components, or the share of the variance that they explain; as many as the rank by
        default.
    whiten : bool
        Whether scores have variance 1.
    standardize : bool
        Whether columns are divided by their standard deviation.
    threads : int, optional
        Threads, at most.
    """

    def __init__(
        self,
        n_components: Union[int, float, None] = None,
        *,
        whiten: bool = False,
        standardize: bool = False,
        threads: Optional[int] = None,
    ) -> None:
        self.n_components = n_components
        self.whiten = whiten
        self.standardize = standardize
        self.threads = threads

    def fit(self, X: Any, y: Any = None) -> PCA:
        """Fits to the rows of X."""
        X = validate_data(self, X, dtype=FLOATS, ensure_min_samples=2)
        found = pca(
            X,
            self.n_components,
            standardize=self.standardize,
            whiten=self.whiten,
            threads=self.threads,
        )
        self._sums: Optional[Accumulator] = None
        return self._set(found, X.shape[0])

    def partial_fit(self, X: Any, y: Any = None) -> PCA:
        """Fits to the rows of X and those of the calls before."""
        sums: Optional[Accumulator] = getattr(self, "_sums", None)
        X = validate_data(self, X, dtype=FLOATS, reset=sums is None)
        if sums is None:
            sums = self._sums = Accumulator(X.shape[1], center=True)
        sums.add(X, threads=self.threads)
        if sums.rows < 2:
            return self
        found = sums.pca(
            self.n_components,
            standardize=self.standardize,
            whiten=self.whiten,
            threads=self.threads,
        )
        return self._set(found, sums.rows)

    def _set(self, found: PrincipalComponents, rows: int) -> PCA:
        self.components_ = found.components
        self.explained_variance_ = found.explained_variance
        self.explained_variance_ratio_ = found.explained_variance_ratio
        self.singular_values_ = found.singular_values
        self.mean_ = found.mean
        self.scale_ = found.scale
        self.n_components_ = found.components.shape[0]
        self.n_samples_ = rows
        shares = found.explained_variance_ratio
        count, most = len(shares), min(rows, len(found.mean))
        # The mean of the variances that are left, as in scikit-learn.
        left = found.explained_variance.sum() / shares.sum() * (1 - shares.sum()) if count else 0.0
        self.noise_variance_ = max(left, 0.0) / (most - count) if count < most else 0.0
        return self

    @property
    def _n_features_out(self) -> int:
        return self.components_.shape[0]

    def _found(self, whiten: bool) -> PrincipalComponents:
        return PrincipalComponents(
            self.components_,
            self.explained_variance_,
            self.explained_variance_ratio_,
            self.singular_values_,
            self.mean_,
            self.scale_,
            whiten,
        )

    def transform(self, X: Any) -> Any:
        """Returns the scores of rows."""
        check_is_fitted(self)
        X = validate_data(self, X, dtype=FLOATS, reset=False)
        return self._found(self.whiten).transform(X).astype(X.dtype, copy=False)

    def inverse_transform(self, X: Any) -> Any:
        """Returns the rows of scores."""
        check_is_fitted(self)
        return self._found(self.whiten).inverse_transform(np.asarray(X))

    @to_nearest
    def score_samples(self, X: Any) -> Any:
        """Returns the logarithm of the density of each row, for the normal distribution whose
        variance is that of the components along them and `noise_variance_` across.

        Source: M. Tipping and C. Bishop, Probabilistic principal component analysis, 1999.
        """
        check_is_fitted(self)
        X = validate_data(self, X, dtype=FLOATS, reset=False)
        n, noise = len(self.mean_), self.noise_variance_
        variances = self.explained_variance_
        found = np.empty(len(X))
        for first in range(0, len(X), BLOCK):
            block = X[first : first + BLOCK]
            scores = self._found(False).transform(block)
            squares = (scores**2 / variances).sum(axis=1)
            if noise > 0:
                centered = (block - self.mean_) / self.scale_
                across = (centered**2).sum(axis=1) - (scores**2).sum(axis=1)
                squares += np.maximum(across, 0.0) / noise
            found[first : first + BLOCK] = squares
        size = np.log(variances).sum() + 2 * np.log(self.scale_).sum() + n * np.log(2 * np.pi)
        if noise > 0:
            size += (n - len(variances)) * np.log(noise)
        return -0.5 * (found + size)

    def score(self, X: Any, y: Any = None) -> float:
        """Returns the mean of `score_samples`."""
        return float(np.mean(self.score_samples(X)))

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.transformer_tags.preserves_dtype = ["float64", "float32"]
        return tags


class _Linear(MultiOutputMixin, RegressorMixin, BaseEstimator):
    """What both regressions do."""

    fit_intercept: bool
    threads: Optional[int]

    def _fit(self, X: Any, y: Any, sample_weight: Any, penalty: float) -> Any:
        X, y = validate_data(self, X, y, dtype=FLOATS, y_numeric=True, multi_output=True)
        weights = None
        if sample_weight is not None:
            weights = _check_sample_weight(sample_weight, X, dtype=np.float64)
        found = lstsq(
            X,
            y,
            weights=weights,
            ridge=penalty,
            intercept=self.fit_intercept,
            standard_errors=False,
            threads=self.threads,
        )
        self.coef_ = found.x.T
        self.intercept_ = found.intercept if self.fit_intercept else 0.0
        self.rank_ = found.rank
        self.condition_ = found.condition
        self.digits_ = found.digits
        return self

    @to_nearest
    def predict(self, X: Any) -> Any:
        """Returns the targets of rows."""
        check_is_fitted(self)
        X = validate_data(self, X, dtype=FLOATS, reset=False)
        return X @ self.coef_.T + self.intercept_


class Ridge(_Linear):
    """Least squares with a penalty, from one pass over the rows in extended precision.

    Parameters
    ----------
    alpha : float
        What the square of the coefficients is multiplied by.
    fit_intercept : bool
        Whether a constant is fitted too.
    threads : int, optional
        Threads, at most.
    """

    def __init__(
        self, alpha: float = 1.0, *, fit_intercept: bool = True, threads: Optional[int] = None
    ) -> None:
        self.alpha = alpha
        self.fit_intercept = fit_intercept
        self.threads = threads

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> Any:
        """Fits to the rows of X and y."""
        return self._fit(X, y, sample_weight, self.alpha)


class LinearRegression(_Linear):
    """Least squares, from one pass over the rows in extended precision.

    Parameters
    ----------
    fit_intercept : bool
        Whether a constant is fitted too.
    threads : int, optional
        Threads, at most.
    """

    def __init__(self, *, fit_intercept: bool = True, threads: Optional[int] = None) -> None:
        self.fit_intercept = fit_intercept
        self.threads = threads

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> Any:
        """Fits to the rows of X and y."""
        return self._fit(X, y, sample_weight, 0.0)
