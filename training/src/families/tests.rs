use catamaran_geometry::mesh::vector::distance;
use catamaran_geometry::mesh::{Components, Edges, Genus};

use super::rotation::mirrored;
use super::skeleton::{Proportions, rest};
use super::*;

/// Number of vertices of the templates in tests.
const VERTICES: usize = 1500;

#[test]
fn templates_are_their_own_mirror_images() {
    for family in Family::TEMPLATED {
        let model = Model::new(family, VERTICES).unwrap();
        let (mesh, mirror) = (model.template(), model.mirror());
        for (v, &m) in mirror.iter().enumerate() {
            assert_eq!(mirror[m as usize] as usize, v);
            assert_eq!(mesh.vertices()[m as usize], mirrored(mesh.vertices()[v]).map(|x| x + 0.0));
        }
        let sorted = |mut face: [u32; 3]| {
            face.sort_unstable();
            face
        };
        let faces: std::collections::HashSet<_> = mesh.faces().iter().map(|&f| sorted(f)).collect();
        assert_eq!(faces.len(), mesh.faces().len());
        for face in mesh.faces() {
            assert!(faces.contains(&sorted(face.map(|v| mirror[v as usize]))), "{family:?}");
        }
    }
}

#[test]
fn templates_are_surfaces_of_one_piece_of_about_the_size_asked_for() {
    for family in Family::TEMPLATED {
        for vertices in [VERTICES, 2 * VERTICES] {
            let mesh = Model::new(family, vertices).unwrap().template().clone();
            let found = mesh.vertices().len() as f64;
            assert!((0.85..1.15).contains(&(found / vertices as f64)), "{family:?}: {found}");
            assert!(mesh.unreferenced_vertices().is_empty());
            assert_eq!(Components::new(&mesh).len(), 1);
            let edges = Edges::new(&mesh);
            edges.require_manifold().unwrap();
            match mesh.genus(&edges).unwrap() {
                Genus::Orientable(0) => {}
                other => panic!("{family:?}: {other:?}"),
            }
            let closed = family != Family::Sheet;
            assert_eq!(edges.boundary().count() == 0, closed);
            assert!(!closed || mesh.volume().unwrap() > 0.0);
            let worst = mesh.qualities().into_iter().fold(1.0, f64::min);
            // The bands and hands of the smallest ones are as thick as the edges of their triangles
            // are long.
            let least = if vertices == VERTICES { 0.01 } else { 0.2 };
            assert!(worst > least, "{family:?}: {worst}");
        }
    }
}

#[test]
fn at_rest_with_its_own_proportions_the_template_stays() {
    for family in [Family::Humanoid, Family::Quadruped, Family::Headphones] {
        let model = Model::new(family, VERTICES).unwrap();
        let Kind::Rigged(skeleton, weights) = &model.kind else { panic!() };
        let before = model.template().vertices();
        let own = Proportions::of_template(skeleton);
        let after = skeleton.skin(before, weights, &own, &rest(skeleton));
        for (&p, &q) in before.iter().zip(&after) {
            assert!(distance(p, q) < 1e-12);
        }
        for held in weights {
            assert!((held.iter().map(|held| held.1).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn shapes_follow_from_their_numbers_and_poses_keep_lengths_about() {
    for family in Family::TEMPLATED {
        let model = Model::new(family, VERTICES).unwrap();
        let shape = |seed, identity, body, pose| model.shape(seed, identity, body, pose).unwrap();
        assert_eq!(shape(1, 2, 0, 3), shape(1, 2, 0, 3));
        let one = shape(1, 2, 0, 0);
        let others = [shape(2, 2, 0, 0), shape(1, 3, 0, 0), shape(1, 2, 1, 0), shape(1, 2, 0, 1)];
        assert!(others.iter().all(|other| *other != one));
        for pose in 0..4 {
            let area = shape(1, 2, 0, pose).area();
            assert!((area / one.area() - 1.0).abs() < 0.05, "{family:?}: {area}");
        }
    }
}

#[test]
fn folds_are_isometric() {
    let model = Model::new(Family::Sheet, VERTICES).unwrap();
    let [one, other] = [0, 1].map(|pose| model.shape(1, 0, 0, pose).unwrap());
    let edges = Edges::new(&one);
    for &[a, b] in edges.ends() {
        let length =
            |mesh: &TriMesh| distance(mesh.vertices()[a as usize], mesh.vertices()[b as usize]);
        assert!((length(&one) / length(&other) - 1.0).abs() < 0.02);
    }
}

#[test]
fn creatures_are_surfaces_of_one_piece_and_their_own_mirror_images() {
    for number in 0..6 {
        let creature = Model::creature(3, number, VERTICES).unwrap();
        let (mesh, mirror) = (creature.template(), creature.mirror());
        assert_eq!(mesh, Model::creature(3, number, VERTICES).unwrap().template());
        let found = mesh.vertices().len() as f64;
        assert!((0.8..1.25).contains(&(found / VERTICES as f64)), "{number}: {found}");
        for (v, &m) in mirror.iter().enumerate() {
            assert_eq!(mesh.vertices()[m as usize], mirrored(mesh.vertices()[v]).map(|x| x + 0.0));
        }
        let edges = Edges::new(mesh);
        edges.require_manifold().unwrap();
        assert_eq!((edges.boundary().count(), Components::new(mesh).len()), (0, 1));
        let posed = creature.shape(1, number, 0, 0).unwrap();
        assert!((0.4..2.5).contains(&(posed.area() / mesh.area())), "{number}");
    }
    let common = Model::new(Family::Creature, VERTICES).unwrap_err();
    assert!(matches!(common, Error::Argument { what: "family", .. }));
}

#[test]
fn too_few_vertices_are_refused() {
    for vertices in [0, 1, 499, 1_000_001] {
        let refused = Model::new(Family::Humanoid, vertices).unwrap_err();
        assert!(matches!(refused, Error::Argument { what: "vertices", .. }));
    }
}
