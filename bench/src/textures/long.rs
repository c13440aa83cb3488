//! Long runs: no agent is lost, and no point gives NaN.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_geometry::mesh::{TriMesh, families};
use catamaran_simulation::texture::newton::{Grid, Newton, NewtonOptions, Points, Polynomial};
use catamaran_simulation::texture::slime::{
    Mask, Options, Simulation, Surface, TangentStep, atlas,
};

use super::surfaces::torus;
use crate::Result;
use crate::plant::Part;

/// 125 million steps of agents on each surface with each walk: 10^9 in all.
const AGENTS: usize = 50_000;
const STEPS: u32 = 2500;
/// Number of steps between checks of all agents.
const LOOK: u32 = 50;
/// Number of texels along a side, few, so that steps dominate the time.
const SIZE: usize = 256;
/// Points of a side of a cube for each power from 2 to 16: 10^8 in all.
const POINTS: u32 = 189;

/// Runs 10^9 steps of agents: on a torus, on a closed surface, on a surface with a boundary, and on
/// a Moebius strip.
///
/// # Errors
/// Names the first agent that is not on its surface, or whose position or heading is not finite.
pub fn long_walks() -> Result<Part> {
    let with_atlas = |mesh: TriMesh| Surface::of_faces(&mesh, atlas(&mesh, SIZE)?);
    let surfaces = [
        ("torus", torus(24, 12)?),
        ("closed, an atlas", with_atlas(families::icosphere(2)?)?),
        ("with a boundary", with_atlas(families::terrain(10, 10, 1)?)?),
        ("Moebius strip", with_atlas(families::moebius(40, 4)?)?),
    ];
    let mut rows = Vec::new();
    for (name, surface) in surfaces {
        for (walk, tangent_step) in [
            ("unfolded", TangentStep::Unfold),
            ("4 sub-steps", TangentStep::Project { substeps: 4 }),
        ] {
            // Ten times as fast as usual: a triangle is crossed every few steps.
            let options = Options::new()
                .agents(AGENTS)
                .size(SIZE)
                .tangent_step(tangent_step)
                .movement_speed(15.0);
            let mut all = Simulation::new(surface.clone(), &options, &Mask::default())?;
            for _ in 0..STEPS / LOOK {
                all.run(LOOK, Par::all(), Progress::none())?;
                all.state().check(all.surface())?;
            }
            // A lost agent would have ended the run.
            rows.push((format!("{name}, {walk}"), vec![AGENTS as f64 * f64::from(STEPS), 0.0]));
        }
    }
    Ok(Part {
        figure: "long walks",
        title: format!("steps of agents; all looked at after every {LOOK} steps"),
        columns: ["agent steps", "lost"].map(String::from).into(),
        rows,
        plots: vec![],
    })
}

/// Computes 10^8 points of fractals of z^n - 1, n = 2 to 16, in cubes around the centre of the null
/// cone.
///
/// # Errors
/// None in practice.
pub fn many_points() -> Result<Part> {
    let mut rows = Vec::new();
    for power in 2..=16 {
        let polynomial = Polynomial::Power(power);
        let newton = Newton::new(&NewtonOptions::new().polynomial(polynomial))?;
        let grid = Points::Grid(Grid::cube(POINTS, 3.0));
        let found = newton.evaluate(grid, Par::all(), Progress::none())?;
        let wrong = |(root, t): &(&u16, &f32)| !t.is_finite() || u32::from(**root) >= power * power;
        let wrong = found.roots.iter().zip(&found.convergence).filter(wrong).count();
        rows.push((format!("n = {power}"), vec![found.roots.len() as f64, wrong as f64]));
    }
    Ok(Part {
        figure: "many points",
        title: "points of Newton's fractals, and how many have no root or no finite t".into(),
        columns: ["points", "without"].map(String::from).into(),
        rows,
        plots: vec![],
    })
}
