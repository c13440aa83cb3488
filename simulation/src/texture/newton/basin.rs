//! Surfaces of the basins of attraction.

use super::points::{Grid, Points};
use super::{Fractal, Newton};
use catamaran::base::{Error, Par, Progress, Result};
use catamaran_geometry::mesh::{Lattice, Rim, TriMesh, label_surface_by};

impl Newton {
    /// Returns the surface of the basin of root number `root`: the region from which Newton's
    /// method leads to this root, at the resolution of the voxels of `grid`, on which `fractal` was
    /// computed. With [`Rim::Closed`] the surface is closed: the region ends at the border of the
    /// outermost voxels.
    ///
    /// Vertices are on the border of the basin to 1/512 of a voxel (along edges between the centres
    /// of voxels, halved eight times); details smaller than a voxel are lost. The surface is a
    /// manifold, its faces are counter-clockwise as seen from outside, and it does not depend on
    /// the number of threads. Basins of different roots do not overlap.
    ///
    /// ```
    /// use catamaran::{Par, base::Progress};
    /// use catamaran_geometry::mesh::Rim;
    /// use catamaran_simulation::texture::newton::{Grid, Newton, NewtonOptions, Points};
    ///
    /// let newton = Newton::new(&NewtonOptions::new())?;
    /// let grid = Grid::cube(32, 3.0);
    /// let fractal = newton.evaluate(Points::Grid(grid), Par::all(), Progress::none())?;
    /// let basin = newton.basin(&grid, &fractal, 0, Rim::Closed, Par::all(), Progress::none())?;
    /// basin.require_closed()?;
    /// let voxels = fractal.roots.iter().filter(|&&root| root == 0).count() as f64;
    /// let voxel = (3.0_f64 / 32.0).powi(3);
    /// assert!((basin.volume().unwrap() / (voxel * voxels) - 1.0).abs() < 0.05);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] for a root that the polynomial does not have, and for a grid whose steps
    /// are not along x, y and z; [`Error::Shape`] when `fractal` has other points than `grid`;
    /// those of [`label_surface_by`] and [`Newton::evaluate`].
    pub fn basin(
        &self,
        grid: &Grid,
        fractal: &Fractal,
        root: u16,
        rim: Rim,
        par: Par,
        progress: Progress<'_>,
    ) -> Result<TriMesh> {
        let count = self.roots() * self.roots();
        if usize::from(root) >= count {
            let why = format!("must be from 0 to {}, is {root}", count - 1);
            return Err(Error::Argument { what: "root", why });
        }
        let lattice = grid.lattice()?;
        let root_at = |points: &[[f64; 3]]| {
            let points: Vec<_> = points.iter().map(|p| p.map(|x| x as f32)).collect();
            // The caller reports progress after each call, and stops there.
            Ok(self.evaluate(Points::List(&points), par, Progress::none())?.roots)
        };
        label_surface_by(&lattice, &fractal.roots, root, rim, root_at, par, progress)
    }
}

impl Grid {
    /// Returns the same points as a lattice.
    fn lattice(&self) -> Result<Lattice> {
        let along = |c: usize| (0..3).all(|k| k == c || self.steps[c][k] == 0.0);
        if !(0..3).all(along) {
            let why = format!("must have steps along x, y and z, has {:?}", self.steps);
            return Err(Error::Argument { what: "grid", why });
        }
        Ok(Lattice {
            counts: self.counts.map(|n| n as usize),
            origin: self.origin.map(f64::from),
            step: [0, 1, 2].map(|c| f64::from(self.steps[c][c])),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::newton::{NewtonOptions, Polynomial};
    use catamaran_geometry::mesh::{Edges, Validation};

    fn cube(polynomial: Polynomial, side: u32) -> (Newton, Grid, Fractal) {
        let newton = Newton::new(&NewtonOptions::new().polynomial(polynomial)).unwrap();
        let grid = Grid::cube(side, 3.0);
        let fractal = newton.evaluate(Points::Grid(grid), Par::all(), Progress::none()).unwrap();
        (newton, grid, fractal)
    }

    #[test]
    fn basins_are_closed_fill_the_cube_and_have_the_volume_of_their_voxels() {
        let (newton, grid, fractal) = cube(Polynomial::Power(3), 40);
        let (voxel, mut whole) = ((3.0_f64 / 40.0).powi(3), 0.0);
        for root in 0..9 {
            let basin = |par| {
                newton.basin(&grid, &fractal, root, Rim::Closed, par, Progress::none()).unwrap()
            };
            let mesh = basin(Par::Seq);
            let edges = Edges::new(&mesh);
            assert!((0..edges.len()).all(|e| edges.faces(e).len() == 2), "root {root}");
            mesh.require_closed().unwrap();
            assert!(mesh.inconsistent_edges(&edges).is_empty(), "root {root}");
            let Validation { problems, .. } = mesh.validate();
            assert!(problems.is_empty(), "root {root}: {problems:?}");
            let count = fractal.roots.iter().filter(|&&found| found == root).count() as f64;
            let ratio = mesh.volume().unwrap() / (voxel * count);
            // Fragments of one voxel have half of its volume.
            assert!((0.8..1.02).contains(&ratio), "root {root}: {ratio}");
            whole += mesh.volume().unwrap();
            assert_eq!(basin(Par::Threads(3)), mesh, "the number of threads changes nothing");
        }
        // The missing volume is at borders of three basins, and at bevelled edges.
        assert!((0.9..1.0).contains(&(whole / 27.0)), "{whole}");
    }

    #[test]
    fn two_roots_are_told_apart_by_planes() {
        // Newton's method for (z - 1) (z + 1) takes alpha to 1 if its real part, x + w, is
        // positive, and beta by x - w: with w = 0 the basins of (1, 1) and (-1, -1) are the halves.
        let polynomial = Polynomial::Roots(vec![[1.0, 0.0], [-1.0, 0.0]]);
        let (newton, grid, fractal) = cube(polynomial, 21);
        let half = newton.basin(&grid, &fractal, 0, Rim::Open, Par::Seq, Progress::none()).unwrap();
        let step = 3.0 / 21.0;
        assert!(!half.faces().is_empty());
        assert!(half.vertices().iter().all(|p| p[0].abs() <= step / 512.0));
        assert!(half.face_normals().iter().all(|n| n[0] < -0.9));
        for root in [1, 2] {
            let none = newton.basin(&grid, &fractal, root, Rim::Closed, Par::Seq, Progress::none());
            let none = none.unwrap();
            // Points of the plane between the basins do not converge: they belong to either basin,
            // or to its border.
            assert!(none.faces().is_empty() || none.volume().unwrap() <= 9.0 * step * 1.01);
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let (newton, grid, fractal) = cube(Polynomial::Power(2), 4);
        let run = |grid: &Grid, root| {
            newton.basin(grid, &fractal, root, Rim::Closed, Par::Seq, Progress::none())
        };
        let refused = run(&grid, 4).unwrap_err().to_string();
        assert!(refused.contains("root: must be from 0 to 3, is 4"), "{refused}");
        let turned = Grid { steps: [grid.steps[1], grid.steps[0], grid.steps[2]], ..grid };
        assert!(run(&turned, 0).unwrap_err().to_string().contains("along x, y and z"));
        assert!(matches!(run(&Grid::cube(5, 3.0), 0), Err(Error::Shape { .. })));
    }
}
