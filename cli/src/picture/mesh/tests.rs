use super::camera::{Projection, Up};
use super::*;
use crate::picture::color::ColorMap;
use catamaran_geometry::mesh::families;

fn triangle(z: f64) -> TriMesh {
    let vertices = vec![[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
    TriMesh::new(vertices, vec![[0, 1, 2]]).unwrap()
}

fn front() -> View {
    View { azimuth: 0.0, elevation: 0.0, up: Up::Y, projection: Projection::Orthographic }
}

fn panel<'a>(mesh: &'a TriMesh, paint: Paint<'a>) -> Panel<'a> {
    Panel { mesh, paint, view: front(), title: "" }
}

fn one<'a>(panel: Panel<'a>, size: usize) -> Scene<'a> {
    Scene { panels: vec![panel], size: (size, size), legend: false, ..Default::default() }
}

fn at(image: &mut Image, x: usize, y: usize) -> Rgb {
    *image.pixel(x, y).unwrap()
}

#[test]
fn a_triangle_covers_its_pixels_and_no_others() {
    let mesh = triangle(0.0);
    let mut image = render(&one(panel(&mesh, Paint::Plain([200, 40, 40])), 100)).unwrap();
    // The margin is 6 pixels: corners at (6, 94), (94, 94), (6, 6).
    for y in 0..100 {
        for x in 0..100 {
            let covered = at(&mut image, x, y) != PAPER;
            let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
            let inside = x > 7.0 && y < 93.0 && y > x + 1.0;
            let outside = x < 5.0 || y > 95.0 || y < x - 1.0;
            assert!((covered || !inside) && !(covered && outside), "{x} {y}");
        }
    }
}

#[test]
fn nearer_faces_hide_farther_ones_in_any_order() {
    let vertices = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
    ];
    let colors = [[200, 0, 0], [200, 0, 0], [200, 0, 0], [0, 0, 200], [0, 0, 200], [0, 0, 200]];
    for faces in [[[0, 1, 2], [3, 4, 5]], [[3, 4, 5], [0, 1, 2]]] {
        let mesh = TriMesh::new(vertices.clone(), faces.to_vec()).unwrap();
        for (azimuth, blue) in [(0.0, true), (180.0, false)] {
            for projection in [Projection::Orthographic, Projection::Perspective] {
                let view = View { azimuth, projection, ..front() };
                let seen = Panel { view, ..panel(&mesh, Paint::Colors(&colors)) };
                let mut image = render(&one(seen, 60)).unwrap();
                // A third from the corner with the right angle.
                let [r, _, b] = at(&mut image, if blue { 20 } else { 39 }, 39);
                assert_eq!(b > r, blue, "{azimuth} {projection:?}: {r} {b}");
            }
        }
    }
}

#[test]
fn faces_beside_sharp_edges_are_evenly_lit() {
    let corner = |i: usize| [i & 1, (i >> 1) & 1, i >> 2].map(|x| x as f64);
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let cube = TriMesh::new((0..8).map(corner).collect(), faces).unwrap();
    let mut image = render(&one(panel(&cube, Paint::Plain([200; 3])), 60)).unwrap();
    let middle = at(&mut image, 30, 30);
    for (x, y) in [(10, 10), (49, 12), (11, 48)] {
        let beside = at(&mut image, x, y);
        let is_same = (0..3).all(|k| beside[k].abs_diff(middle[k]) <= 1);
        assert!(is_same, "{x} {y}: {beside:?} {middle:?}");
    }
}

#[test]
fn a_flat_side_with_a_corner_that_points_inwards_is_evenly_lit() {
    let outline = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]];
    let corner = |z: u32| move |[x, y]: [u32; 2]| [x, y, z].map(f64::from);
    let vertices = outline.map(corner(0)).into_iter().chain(outline.map(corner(1))).collect();
    let flat = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    let bottom = flat.map(|[a, b, c]| [a, c, b]);
    let top = flat.map(|face| face.map(|v| v + 6));
    let next = |v: u32| (v + 1) % 6;
    let sides = (0..6).flat_map(|v| [[v, next(v), v + 6], [next(v), next(v) + 6, v + 6]]);
    let faces = bottom.into_iter().chain(top).chain(sides).collect();
    let prism = TriMesh::new(vertices, faces).unwrap();
    let mut image = render(&one(panel(&prism, Paint::Plain([200; 3])), 60)).unwrap();
    let inner = at(&mut image, 26, 34);
    for (x, y) in [(12, 12), (12, 48), (48, 48), (26, 20), (40, 34)] {
        let other = at(&mut image, x, y);
        let is_same = (0..3).all(|k| other[k].abs_diff(inner[k]) <= 1);
        assert!(is_same, "{x} {y}: {other:?} {inner:?}");
    }
}

#[test]
fn pictures_of_the_same_scene_have_the_same_bytes() {
    let mesh = families::icosphere(3).unwrap();
    let values: Vec<f64> = mesh.vertices().iter().map(|p| p[0] * p[1]).collect();
    let scene = Scene {
        panels: vec![Panel { title: "xy", ..panel(&mesh, Paint::Values(&values)) }],
        size: (120, 90),
        edges: true,
        ..Default::default()
    };
    let image = render(&scene).unwrap();
    assert_eq!(image, render(&scene).unwrap());
    assert_eq!((image.width(), image.height()), (120 + legend::WIDTH, 90));
}

#[test]
fn a_mesh_without_faces_gives_an_empty_picture() {
    for vertices in [vec![], vec![[1.0; 3]]] {
        let mesh = TriMesh::new(vertices, vec![]).unwrap();
        let image = render(&one(panel(&mesh, Paint::Plain([9; 3])), 30)).unwrap();
        assert_eq!(image, Image::new(30, 30, PAPER));
    }
    let none = Scene { size: (10, 10), ..Default::default() };
    assert_eq!(render(&none).unwrap(), Image::new(1, 10, PAPER));
}

#[test]
fn wrong_sizes_are_errors() {
    let mesh = triangle(0.0);
    assert!(render(&one(panel(&mesh, Paint::Values(&[1.0])), 10)).is_err());
    assert!(render(&one(panel(&mesh, Paint::Colors(&[[0; 3]; 4])), 10)).is_err());
    assert!(render(&one(panel(&mesh, Paint::Plain([0; 3])), 0)).is_err());
    assert!(render(&one(panel(&mesh, Paint::Plain([0; 3])), 100_000)).is_err());
}

#[test]
fn values_have_the_colours_of_the_scale_that_all_panels_share() {
    let mesh = triangle(0.0);
    let (low, high) = ([0.0; 3], [1.0; 3]);
    let panels = vec![panel(&mesh, Paint::Values(&low)), panel(&mesh, Paint::Values(&high))];
    let scene = Scene { panels, size: (60, 60), ..Default::default() };
    let mut image = render(&scene).unwrap();
    let ([r, ..], [s, ..]) = (at(&mut image, 20, 40), at(&mut image, 80, 40));
    assert!(r < 100 && s > 150, "dark blue and yellow: {r} {s}");
    let scale = Some(ColorScale { map: ColorMap::Sequential, low: 1.0, high: 2.0 });
    let mut image = render(&Scene { scale, ..scene }).unwrap();
    assert!(at(&mut image, 80, 40)[0] < 100, "the scale that is given is used");
}

#[test]
fn views_are_read_as_they_are_written() {
    let view: View = "30, -10".parse().unwrap();
    assert_eq!((view.azimuth, view.elevation, view.up), (30.0, -10.0, Up::Y));
    assert_eq!("0,90,flat".parse::<View>().unwrap().projection, Projection::Orthographic);
    for wrong in ["", "30", "a,b", "0,91", "0,0,x", "0,0,flat,1", "nan,0"] {
        assert!(wrong.parse::<View>().is_err(), "{wrong}");
    }
}

#[test]
fn up_is_up_and_right_is_right() {
    // Seen along -z resp. along y, the third corner is up; from behind, the second is left.
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for (up, azimuth, right) in [
        (Up::X, 0.0, true),
        (Up::Y, 0.0, true),
        (Up::Z, 0.0, true),
        (Up::X, 180.0, false),
        (Up::Y, 180.0, false),
        (Up::Z, 180.0, false),
    ] {
        let (side, top) = match up {
            Up::X => (z, x),
            Up::Y => (x, y),
            Up::Z => (x, z),
        };
        let mesh = TriMesh::new(vec![[0.0; 3], side, top], vec![[0, 1, 2]]).unwrap();
        let camera = Camera::new(&mesh, &View { azimuth, up, ..front() }, 100.0, 100.0, 0.0);
        let [a, b, c] = [0, 1, 2].map(|v| camera.project(mesh.vertices()[v]));
        assert!(c.y < a.y - 50.0 && (b.x > a.x) == right, "{up:?} {azimuth}");
    }
}

#[test]
fn an_example_is_written_as_png() {
    let folder = std::env::var_os("CATAMARAN_PICTURES");
    let temporary = tempfile::tempdir().unwrap();
    let folder = folder.map_or_else(|| temporary.path().to_owned(), std::path::PathBuf::from);
    let sphere = families::icosphere(5).unwrap();
    let harmonic = |p: &[f64; 3]| p[0] * p[1] * p[2] * (3.0 + 4.0 * p[2]);
    let values: Vec<f64> = sphere.vertices().iter().map(harmonic).collect();
    let knot = families::knot(2, 3, 400, 40, 0.45).unwrap();
    let height: Vec<f64> = knot.vertices().iter().map(|p| p[2].abs()).collect();
    let terrain = families::terrain(60, 60, 7).unwrap();
    let view = View { elevation: 35.0, up: Up::Z, ..View::default() };
    let colors: Vec<Rgb> = terrain
        .vertices()
        .iter()
        .map(|p| [0, 1, 0].map(|k: usize| (90.0 + 160.0 * p[k].fract().abs()) as u8))
        .collect();
    let size = (480, 480);
    let scenes = [
        (
            "harmonic.png",
            vec![Panel {
                mesh: &sphere,
                paint: Paint::Values(&values),
                view: View::default(),
                title: "A spherical harmonic",
            }],
            false,
        ),
        (
            "knot.png",
            vec![
                Panel {
                    mesh: &knot,
                    paint: Paint::Values(&height),
                    view: View { elevation: 60.0, up: Up::Z, ..View::default() },
                    title: "before",
                },
                Panel { mesh: &knot, paint: Paint::Plain([176, 190, 205]), view, title: "after" },
            ],
            false,
        ),
        (
            "terrain.png",
            vec![Panel { mesh: &terrain, paint: Paint::Colors(&colors), view, title: "" }],
            true,
        ),
    ];
    for (name, panels, edges) in scenes {
        let image = render(&Scene { panels, size, edges, ..Default::default() }).unwrap();
        let path = folder.join(name);
        let output = catamaran::io::Output::create(&path, catamaran::io::Overwrite::Replace);
        image.write(output.unwrap()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(&bytes[1..4], b"PNG");
    }
}
