//! Surfaces: what is refused, automatic atlases, and real meshes.

use catamaran::base::Progress;
use catamaran::{Error, Par};
use catamaran_geometry::mesh::io::{self as meshes, Attribute};
use catamaran_geometry::mesh::{TriMesh, families};
use catamaran_simulation::texture::slime::{Surface, Texels, atlas, fitted, smallest_size};

use super::support::{options, simulation, with_atlas};

#[test]
fn the_charts_of_an_atlas_share_no_texel() {
    let mesh = families::torus(7, 5, 2.0, 0.7).unwrap();
    let size = smallest_size(mesh.faces().len());
    assert!(matches!(atlas(&mesh, size - 1), Err(Error::Argument { what: "size", .. })));
    let surface = with_atlas(&mesh, size);
    let texels = Texels::new(&surface, size).unwrap();
    // Every triangle has texels of its own, and as much area in them as it has.
    let mut areas = vec![0.0; surface.len()];
    for (&owner, &area) in texels.owners().iter().zip(texels.areas()) {
        if let Some(sum) = areas.get_mut(owner as usize) {
            *sum += f64::from(area);
        }
    }
    for (found, expected) in areas.iter().zip(surface.areas()) {
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    }
}

#[test]
fn what_no_agent_can_walk_on_is_named() {
    let mesh = families::grid(1, 1).unwrap();
    let good = |v: u32| [mesh.vertices()[v as usize][0], mesh.vertices()[v as usize][1]];
    let uv: Vec<[[f64; 2]; 3]> = mesh.faces().iter().map(|face| face.map(good)).collect();
    let refused = |mesh: &TriMesh, uv: Vec<[[f64; 2]; 3]>| match Surface::of_faces(mesh, uv) {
        Err(Error::Mesh { what, element }) => format!("{element}: {what}"),
        other => panic!("{other:?}"),
    };
    let mut bad = uv.clone();
    bad[1] = [[0.5, 0.5]; 3];
    assert_eq!(refused(&mesh, bad), "face 1: has no area in the texture");
    let mut bad = uv.clone();
    bad[0][2] = [1.5, 0.0];
    assert_eq!(refused(&mesh, bad), "face 0: texture coordinates must be from 0 to 1, one is 1.5");
    let mut bad = uv.clone();
    bad[0][2] = [f64::NAN, 0.0];
    assert_eq!(refused(&mesh, bad), "face 0: texture coordinates must be from 0 to 1, one is NaN");
    let flat = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], vec![[0, 1, 2]]);
    assert_eq!(refused(&flat.unwrap(), uv[..1].to_vec()), "face 0: has no area");
    let fin = TriMesh::new(
        vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, -1.0, 0.0]],
        vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]],
    );
    let three = vec![uv[0]; 3];
    assert!(refused(&fin.unwrap(), three).starts_with("edge 0-1: has 3 faces"));
    let absent = Attribute { values: vec![], corners: Some(vec![[u32::MAX; 3]; 2]) };
    let error = Surface::new(&mesh, &absent).unwrap_err().to_string();
    assert_eq!(error, "face 0: has no texture coordinates");
    // A fold is walked on, and told.
    let mut folded = uv;
    folded[1] = [folded[0][0], folded[0][2], [1.0, 0.1]];
    let surface = Surface::of_faces(&mesh, folded).unwrap();
    assert!(surface.flipped().len() <= 1);
}

#[test]
fn coordinates_that_repeat_are_fitted() {
    let uv = Attribute { values: vec![[-0.5, 0.0], [1.5, 0.5]], corners: None };
    assert_eq!(fitted(&uv).values, [[0.0, 0.0], [1.0, 0.25]]);
    let inside = Attribute { values: vec![[0.25, 0.5]], corners: None };
    assert_eq!(fitted(&inside), inside);
}

#[test]
fn real_meshes_carry_slime() {
    // The part of the texels that carry anything after 20 steps.
    for (name, expected) in [
        ("momas_torus.obj.gz", 0.130),
        ("spot.obj.gz", 0.108),
        ("moebius.obj.gz", 0.593),
        ("ofp_bunny10k.off.gz", 0.0403),
    ] {
        let Some(path) = crate::common::data(&format!("meshes/{name}")) else { continue };
        let file = meshes::read(&path).unwrap();
        let surface = match file.uv.as_ref().map(|uv| Surface::new(&file.mesh, &fitted(uv))) {
            Some(Ok(surface)) => surface,
            _ => with_atlas(&file.mesh, smallest_size(file.mesh.faces().len())),
        };
        let size = smallest_size(file.mesh.faces().len());
        let mut all = simulation(surface, &options(2000, size));
        all.run(20, Par::all(), Progress::none()).unwrap();
        assert_eq!(all.state().check(all.surface()), Ok(()), "{name}");
        let coverage = all.coverage(Par::Seq)[0].coverage;
        assert!((coverage / expected - 1.0).abs() < 0.05, "{name}: {coverage}");
    }
}
