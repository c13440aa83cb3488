//! The surfaces of the figures, each with its texture.

use std::f64::consts::{PI, TAU};
#[cfg(feature = "opencl")]
use std::path::PathBuf;

#[cfg(feature = "opencl")]
use catamaran_geometry::mesh::io::read;
use catamaran_geometry::mesh::{TriMesh, families};
use catamaran_simulation::texture::slime::Surface;
#[cfg(feature = "opencl")]
use catamaran_simulation::texture::slime::{atlas, fitted};

use crate::Result;

/// Returns the unit square, flat in its texture.
pub fn square() -> Result<Surface> {
    let mesh = families::grid(40, 40)?;
    let at = |v: u32| [mesh.vertices()[v as usize][0], mesh.vertices()[v as usize][1]];
    Ok(Surface::of_faces(&mesh, mesh.faces().iter().map(|face| face.map(at)).collect())?)
}

/// Returns ten meshes and their names: real ones where `CATAMARAN_DATA` (default ../shared) has
/// them, in their own texture or, without one, in an atlas for `size` texels; generated ones in
/// their place.
#[cfg(feature = "opencl")]
pub fn ten(size: usize) -> Result<Vec<(String, Surface)>> {
    let data = std::env::var_os("CATAMARAN_DATA").map_or("../shared".into(), PathBuf::from);
    let in_atlas =
        |mesh: &TriMesh| -> Result<Surface> { Ok(Surface::of_faces(mesh, atlas(mesh, size)?)?) };
    let mut all = vec![("torus".to_owned(), torus(96, 48)?), ("square".to_owned(), square()?)];
    let real = ["momas_torus.obj.gz", "spot.obj.gz", "moebius.obj.gz", "ofp_bunny10k.off.gz"];
    for name in real {
        let path = data.join("meshes").join(name);
        if !path.exists() {
            continue;
        }
        let file = read(&path)?;
        let own = file.uv.as_ref().and_then(|uv| Surface::new(&file.mesh, &fitted(uv)).ok());
        let surface = own.map_or_else(|| in_atlas(&file.mesh), Ok)?;
        all.push((name.split('.').next().unwrap_or(name).to_owned(), surface));
    }
    let generated: [(&str, TriMesh); 8] = [
        ("icosphere", families::icosphere(5)?),
        ("knot", families::knot(2, 3, 240, 24, 0.45)?),
        ("terrain", families::terrain(80, 80, 7)?),
        ("figure", families::figure(40, 0.5)?),
        ("long torus", families::torus(160, 20, 4.0, 0.5)?),
        ("Moebius strip", families::moebius(200, 16)?),
        ("coarse sphere", families::icosphere(3)?),
        ("trefoil", families::knot(3, 2, 160, 16, 0.4)?),
    ];
    for (name, mesh) in &generated[..10 - all.len()] {
        all.push(((*name).to_owned(), in_atlas(mesh)?));
    }
    Ok(all)
}

/// Returns a torus around which its texture is wrapped once in each direction: stretched outside,
/// compressed inside.
pub fn torus(around: usize, tube: usize) -> Result<Surface> {
    wrapped(around, tube, [true, true], |u, v| {
        let ring = 1.0 + 0.5 * (TAU * v).cos();
        [ring * (TAU * u).cos(), ring * (TAU * u).sin(), 0.5 * (TAU * v).sin()]
    })
}

/// Returns a sphere by longitude and latitude, open at its poles by a thousandth of its height.
pub fn sphere(around: usize, along: usize) -> Result<Surface> {
    wrapped(around, along, [true, false], |u, v| {
        let latitude = PI * (0.001 + 0.998 * v - 0.5);
        [latitude.cos() * (TAU * u).cos(), latitude.cos() * (TAU * u).sin(), latitude.sin()]
    })
}

/// Returns the unit square in the texture, mapped into space; joined sides share vertices.
fn wrapped(
    columns: usize,
    rows: usize,
    joined: [bool; 2],
    place: impl Fn(f64, f64) -> [f64; 3],
) -> Result<Surface> {
    let lines = [columns + usize::from(!joined[0]), rows + usize::from(!joined[1])];
    let part = |i: usize, of: usize| i as f64 / of as f64;
    let mut vertices = Vec::new();
    for i in 0..lines[0] {
        vertices.extend((0..lines[1]).map(|j| place(part(i, columns), part(j, rows))));
    }
    let (mut faces, mut uv) = (Vec::new(), Vec::new());
    for i in 0..columns {
        for j in 0..rows {
            let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            for face in [[0, 1, 2], [0, 2, 3]] {
                let number = |k: usize| {
                    let [i, j] = corners[k];
                    (i % lines[0] * lines[1] + j % lines[1]) as u32
                };
                faces.push(face.map(number));
                uv.push(face.map(|k| [part(corners[k][0], columns), part(corners[k][1], rows)]));
            }
        }
    }
    Ok(Surface::of_faces(&TriMesh::new(vertices, faces)?, uv)?)
}
