"""Estimators, as scikit-learn checks them."""

import numpy as np
import pytest

sklearn = pytest.importorskip("sklearn")

from sklearn import decomposition, linear_model  # noqa: E402
from sklearn.utils.estimator_checks import parametrize_with_checks  # noqa: E402

from catamaran.sklearn import PCA, LinearRegression, Ridge  # noqa: E402


@parametrize_with_checks([PCA(), LinearRegression(), Ridge()])
def test_estimators(estimator, check):
    check(estimator)


def test_they_find_what_scikit_learn_finds(rng):
    x, y, w = rng.standard_normal((60, 4)) + 2, rng.standard_normal((60, 2)), rng.uniform(1, 2, 60)
    for ours, theirs in [
        (LinearRegression(), linear_model.LinearRegression()),
        (LinearRegression(fit_intercept=False), linear_model.LinearRegression(fit_intercept=False)),
        (Ridge(2.0), linear_model.Ridge(2.0)),
    ]:
        ours, theirs = ours.fit(x, y, w), theirs.fit(x, y, w)
        assert np.allclose(ours.coef_, theirs.coef_) and np.allclose(
            ours.intercept_, theirs.intercept_
        )
        assert np.allclose(ours.predict(x), theirs.predict(x))
    for whiten in (False, True):
        ours, theirs = PCA(3, whiten=whiten).fit(x), decomposition.PCA(3, whiten=whiten).fit(x)
        assert np.allclose(np.abs(ours.transform(x)), np.abs(theirs.transform(x)))
        assert np.allclose(
            ours.inverse_transform(ours.transform(x)), theirs.inverse_transform(theirs.transform(x))
        )
