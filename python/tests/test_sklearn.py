"""Estimators, as scikit-learn checks them."""

import pickle
import subprocess
import sys

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


def test_frames_give_the_names_of_features(rng):
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(rng.standard_normal((20, 3)), columns=["x", "y", "z"])
    for estimator in (PCA(2), LinearRegression(), Ridge()):
        estimator.fit(frame, frame["x"])
        assert list(estimator.feature_names_in_) == ["x", "y", "z"]
        call = estimator.transform if hasattr(estimator, "transform") else estimator.predict
        with pytest.raises(ValueError, match="feature names"):
            call(frame.rename(columns={"x": "other"}))


@pytest.mark.parametrize("options", [{}, {"n_components": 2}, {"n_components": 3, "whiten": True}])
def test_scores_are_those_of_scikit_learn(rng, options):
    x = rng.standard_normal((80, 5)) * [5, 3, 2, 1, 0.5] + 7
    new = rng.standard_normal((9, 5)) + 7
    ours = PCA(**options).fit(x)
    # Whitening changes scores, and no density. That of scikit-learn scales its components twice.
    theirs = decomposition.PCA(options.get("n_components")).fit(x)
    assert np.isclose(ours.noise_variance_, theirs.noise_variance_, atol=1e-12)
    assert np.allclose(ours.score_samples(new), theirs.score_samples(new))
    assert np.isclose(ours.score(x), theirs.score(x))


def test_batches_are_the_whole(rng):
    x = rng.standard_normal((500, 6)) @ rng.standard_normal((6, 6)) + 3
    whole, parts = PCA(4).fit(x), PCA(4)
    for batch in np.array_split(x, 7):
        parts.partial_fit(batch)
    assert parts.n_samples_ == 500
    assert np.allclose(parts.explained_variance_, whole.explained_variance_)
    assert np.allclose(np.abs(parts.components_), np.abs(whole.components_), atol=1e-7)
    again = pickle.loads(pickle.dumps(parts)).partial_fit(x[:10])
    assert again.n_samples_ == 510 and np.allclose(parts.mean_, x.mean(axis=0))
    # Of few rows there are no more components than their rank.
    assert PCA().partial_fit(x[:4]).components_.shape == (3, 6)
    # A fit forgets them.
    assert parts.fit(x[:50]).n_samples_ == 50 and parts.partial_fit(x[:9]).n_samples_ == 9


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the unit of ru_maxrss")
def test_transform_copies_no_rows():
    script = """
import resource
import numpy as np
from catamaran.sklearn import PCA
x = np.ones((400_000, 60))
x[:, 0] = np.arange(400_000)
found = PCA(1).fit(x)
found.transform(x[:1000])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
found.transform(x)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    # In KiB; the rows take 187,500.
    assert int(done.stdout) < 60_000
