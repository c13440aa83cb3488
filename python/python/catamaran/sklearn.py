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
from ._gram import lstsq, pca
from ._options import to_nearest

require_own()

__all__ = ["LinearRegression", "PCA", "Ridge"]

FLOATS = [np.float64, np.float32]


class PCA(ClassNamePrefixFeaturesOutMixin, TransformerMixin, BaseEstimator):
    """Principal components, from one pass over the rows in extended precision.

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
        """Fit to the rows of X."""
        X = validate_data(self, X, dtype=FLOATS, ensure_min_samples=2)
        found = pca(
            X,
            self.n_components,
            standardize=self.standardize,
            whiten=self.whiten,
            threads=self.threads,
        )
        self.components_ = found.components
        self.explained_variance_ = found.explained_variance
        self.explained_variance_ratio_ = found.explained_variance_ratio
        self.singular_values_ = found.singular_values
        self.mean_ = found.mean
        self.scale_ = found.scale
        self.n_components_ = found.components.shape[0]
        self.n_samples_ = X.shape[0]
        return self

    @property
    def _n_features_out(self) -> int:
        return self.components_.shape[0]

    def _divisor(self) -> Any:
        return np.sqrt(self.explained_variance_) if self.whiten else 1.0

    @to_nearest
    def transform(self, X: Any) -> Any:
        """Return the scores of rows."""
        check_is_fitted(self)
        X = validate_data(self, X, dtype=FLOATS, reset=False)
        scores = ((X - self.mean_) / self.scale_) @ self.components_.T
        return (scores / self._divisor()).astype(X.dtype, copy=False)

    @to_nearest
    def inverse_transform(self, X: Any) -> Any:
        """Return the rows of scores."""
        check_is_fitted(self)
        X = np.asarray(X)
        return (X * self._divisor()) @ self.components_ * self.scale_ + self.mean_

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
        """Return the targets of rows."""
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
        """Fit to the rows of X and y."""
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
        """Fit to the rows of X and y."""
        return self._fit(X, y, sample_weight, 0.0)
