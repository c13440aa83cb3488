"""A^T A: a covariance, and least squares where the normal equations in float64 have no digits."""

import matplotlib.pyplot as plt
import numpy as np
from _picture import save

import catamaran

rng = np.random.default_rng(0)

# A covariance of columns that hang together, and the correlation.
mixing = np.exp(-np.abs(np.subtract.outer(np.arange(40), np.arange(40))) / 6)
x = rng.standard_normal((20_000, 40)) @ mixing
correlation = catamaran.corrcoef(x)
print(catamaran.plan(*x.shape))

# Polynomials of growing degree on [-9, -3]: conditions up to 1e16.
t = np.linspace(-9, -3, 200)
degrees = np.arange(1, 12)
errors = {"catamaran.lstsq": [], "numpy.linalg.lstsq (QR)": [], "numpy: normal equations": []}
for degree in degrees:
    a = np.vander(t, degree + 1, increasing=True)
    truth = np.ones(degree + 1)
    b = a @ truth
    found = [
        catamaran.lstsq(a, b, standard_errors=False).x,
        np.linalg.lstsq(a, b, rcond=0)[0],
        np.linalg.solve(a.T @ a, a.T @ b),
    ]
    for name, solution in zip(errors, found):
        errors[name].append(max(np.abs(solution - truth).max(), 1e-16))

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
image = left.imshow(correlation, cmap="RdBu_r", vmin=-1, vmax=1)
left.set_title("Correlation of 20,000 rows, 40 columns", fontsize=10)
left.set(xlabel="column", ylabel="column")
figure.colorbar(image, ax=left, shrink=0.8)
for (name, values), marker in zip(errors.items(), "os^"):
    right.semilogy(degrees, values, marker=marker, label=name)
right.set(xlabel="degree of the polynomial", ylabel="largest error of a coefficient")
right.set_title("Least squares on [-9, -3]", fontsize=10)
right.legend(fontsize=8)
right.grid(alpha=0.3)
save(figure, __file__)
