//! Scenes of glTF: what extensions, skins, morph targets and nodes do to the triangles, and that
//! nothing is left out without a note.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use catamaran_geometry::mesh::io::{GltfEncoding, MeshFile, MeshFormat, read, read_bytes};

use crate::common::data;
use crate::mesh_files::{SQUARE, gltf, note, refusal, square_bytes};

const GLB: MeshFormat = MeshFormat::Gltf(GltfEncoding::Binary);
const GLTF: MeshFormat = MeshFormat::Gltf(GltfEncoding::Text);

/// The square of [`SQUARE`], changed by `change`, with more of a document after it.
fn square(change: (&str, &str), more: &str) -> Vec<u8> {
    assert!(SQUARE.contains(change.0), "{change:?}");
    gltf(&format!("{}{more}", SQUARE.replace(change.0, change.1)), &square_bytes())
}

fn read_square(change: (&str, &str), more: &str) -> MeshFile {
    read_bytes(&square(change, more), GLB).unwrap_or_else(|e| panic!("{change:?}, {more}: {e}"))
}

const NONE: (&str, &str) = ("", "");
const PRIMITIVE: &str = r#"{"attributes": {"POSITION": 0}, "indices": 1}"#;

/// Numbers of a further buffer view after those of the square, as accessors from number 2 on.
fn with_floats(document: &str, accessors: &[(&str, &[f32])]) -> Vec<u8> {
    let mut bytes = square_bytes();
    bytes.resize(56, 0);
    let (mut views, mut heads) = (String::new(), String::new());
    for (kind, values) in accessors {
        let width = if *kind == "VEC3" { 3 } else { 4 };
        let (start, length, count) = (bytes.len(), 4 * values.len(), values.len() / width);
        views += &format!(r#", {{"buffer": 0, "byteOffset": {start}, "byteLength": {length}}}"#);
        let view = 2 + heads.matches("bufferView").count();
        heads += &format!(
            r#", {{"bufferView": {view}, "componentType": 5126, "type": "{kind}", "count": {count}}}"#
        );
        bytes.extend(values.iter().flat_map(|x| x.to_le_bytes()));
    }
    let document = SQUARE
        .replace(
            r#""byteOffset": 48, "byteLength": 6}"#,
            &format!("\"byteOffset\": 48, \"byteLength\": 6}}{views}"),
        )
        .replace(
            r#""type": "SCALAR", "count": 6}"#,
            &format!("\"type\": \"SCALAR\", \"count\": 6}}{heads}"),
        )
        .replace(
            r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]"#,
            document,
        );
    gltf(&document, &bytes)
}

#[test]
fn extensions_that_a_file_requires_are_known_or_an_error() {
    for name in ["FOO_bar", "KHR_mesh_folding", "CESIUM_RTC", "KHR", "", "MPEG_accessor_timed"] {
        let required =
            format!(r#", "extensionsUsed": ["{name}"], "extensionsRequired": ["{name}"]"#);
        let said = refusal(&square(NONE, &required), GLB).1;
        assert_eq!(said, format!("requires the extension {name}, which is not supported"));
    }
    let name = "KHR_meshopt_compression";
    let required = format!(r#", "extensionsRequired": ["KHR_materials_unlit", "{name}"]"#);
    let said = refusal(&square(NONE, &required), GLB).1;
    let what = format!("compressed by the extension {name}, which is not supported: import");
    assert!(said.starts_with(&what), "{said}");
    for name in [
        "KHR_draco_mesh_compression",
        "KHR_mesh_quantization",
        "KHR_technique_webgl",
        "KHR_texture_basisu",
        "KHR_texture_transform",
        "KHR_materials_variants",
        "KHR_lights_punctual",
        "KHR_node_visibility",
        "EXT_mesh_gpu_instancing",
        "EXT_texture_webp",
        "MSFT_lod",
        "VRMC_vrm",
    ] {
        let required = format!(r#", "extensionsRequired": ["{name}"]"#);
        let file = read_square(NONE, &required);
        assert_eq!((file.mesh.area(), &file.notes[..]), (1.0, &[][..]), "{name}");
    }
}

#[test]
fn compressed_numbers_are_an_error_unless_the_file_has_them_uncompressed_too() {
    let packed = r#", "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0}}}"#;
    let packed = &PRIMITIVE.replace("1}", &format!("1{packed}"));
    let used = r#", "extensionsUsed": ["KHR_draco_mesh_compression"]"#;
    // With the numbers in the file, a reader may ignore the extension.
    let file = read_square((PRIMITIVE, packed), used);
    assert_eq!((file.mesh.area(), &file.notes[..]), (1.0, &[][..]));
    let missing = |view: &str, primitive: &str, used: &str| {
        let document = SQUARE.replace(view, "{").replace(PRIMITIVE, primitive);
        gltf(&format!("{document}{used}"), &square_bytes())
    };
    let said = "mesh 0, primitive 0: compressed by the extension KHR_draco_mesh_compression, but \
                its numbers are not there: import it into Blender, and export without compression";
    for view in [r#"{"bufferView": 0, "#, r#"{"bufferView": 1, "#] {
        // Named in the list of extensions only.
        assert_eq!(refusal(&missing(view, PRIMITIVE, used), GLB).1, said, "{view}");
        // The view has no stream.
        for used in [used, ""] {
            let said = refusal(&missing(view, packed, used), GLB).1;
            assert!(said.contains("KHR_draco_mesh_compression: can't be unpacked"), "{said}");
        }
    }
    let other = packed.replace("KHR_draco_mesh_compression", "FOO_points");
    let refused = refusal(&missing(r#"{"bufferView": 0, "#, &other, ""), GLB).1;
    assert!(refused.ends_with("requires the extension FOO_points, which is not supported"));
    // Zeros that no extension replaces.
    let file = read_bytes(&missing(r#"{"bufferView": 0, "#, PRIMITIVE, ""), GLB).unwrap();
    note(&file, "took 0 for positions and vertex numbers that are not in the file: 1");
}

/// A square that Draco packs by its connectivity, with 11 bits for a coordinate: DracoPy 2.2.
const CONNECTED: &str = "\
    RFJBQ08CAgEBAAAABAIAAgAAAR//AREB/wAAAQAJAwAAAgABAQADAwEgASADACCEmJAAAAAAAP8HAAAAAAAA\
    AAAAAAAAAAAAAIA/Cw==";

/// The same as lists, with colours, texture coordinates and normals: attributes 0 to 2.
const LISTED: &str = "\
    RFJBQ08CAgEAAAACBAEAAQIAAgMBBAICAwEAAwkCAQEBCQMAAgAJAwADAQAAAgABAQADAwEgASADAPCDMbAB\
    AAAAAP8AAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAgD8AAAAAAACAPwAAAAAAAAAAAACAPwAAAAAAAAAAAACA\
    PwAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwABAQADAwEwARADADSCiAQAAAAA/wcAAAAAAAAAAAAAAAAAAAAA\
    gD8L";

/// A document with a primitive of these attributes, each with its accessor and its number in a
/// stream of Draco.
fn draco(stream: &str, attributes: &[(&str, &str, u32)]) -> String {
    let (mut named, mut ids, mut accessors) = (vec![], vec![], vec![]);
    for (i, (name, accessor, id)) in attributes.iter().enumerate() {
        named.push(format!("\"{name}\": {i}"));
        ids.push(format!("\"{name}\": {id}"));
        accessors.push(format!("{{{accessor}, \"count\": 4}}"));
    }
    let (named, ids, accessors) = (named.join(", "), ids.join(", "), accessors.join(", "));
    let (size, indices) = (STANDARD.decode(stream).unwrap().len(), attributes.len());
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "extensionsRequired": ["KHR_draco_mesh_compression"],
        "buffers": [{{"byteLength": {size}, "uri": "data:;base64,{stream}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": {size}}}],
        "accessors": [{accessors}, {{"componentType": 5123, "type": "SCALAR", "count": 6}}],
        "meshes": [{{"primitives": [{{"attributes": {{{named}}}, "indices": {indices},
        "extensions": {{"KHR_draco_mesh_compression": {{"bufferView": 0,
        "attributes": {{{ids}}}}}}}}}]}}]}}"#
    )
}

const POSITION: &str = r#""componentType": 5126, "type": "VEC3""#;

#[test]
fn primitives_that_draco_packs_are_unpacked() {
    let text = draco(CONNECTED, &[("POSITION", POSITION, 0)]);
    let file = read_bytes(text.as_bytes(), GLTF).unwrap_or_else(|e| panic!("{e}"));
    let corners = [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    assert_eq!(
        (file.mesh.vertices(), file.mesh.faces()),
        (&corners[..], &[[0, 1, 2], [1, 3, 2]][..])
    );
    assert!(file.notes.is_empty(), "{:?}", file.notes);
    // The stream counts, and it has triangles where there were strips.
    for (old, new) in
        [("\"count\": 4", "\"count\": 3"), ("\"indices\"", "\"mode\": 5, \"indices\"")]
    {
        let changed = text.replacen(old, new, 1);
        assert_eq!(read_bytes(changed.as_bytes(), GLTF).unwrap().mesh, file.mesh, "{new}");
    }
    let color = r#""componentType": 5121, "normalized": true, "type": "VEC3""#;
    let uv = r#""componentType": 5126, "type": "VEC2""#;
    let all = [
        ("POSITION", POSITION, 3),
        ("COLOR_0", color, 0),
        ("TEXCOORD_0", uv, 1),
        ("NORMAL", POSITION, 2),
    ];
    let listed = read_bytes(draco(LISTED, &all).as_bytes(), GLTF).unwrap();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let faces = [[0, 1, 2], [0, 2, 3]];
    assert_eq!((listed.mesh.vertices(), listed.mesh.faces()), (&corners[..], &faces[..]));
    let colors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
    assert_eq!(listed.colors.unwrap(), colors.map(|[r, g, b]| [r, g, b, 1.0]));
    // From the bottom, not from the top.
    let uv = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    assert_eq!(listed.uv.unwrap().of_vertices(), Some(&uv[..]));
    assert_eq!(listed.normals.unwrap().of_vertices(), Some(&[[0.0, 0.0, 1.0]; 4][..]));
}

#[test]
fn broken_streams_of_draco_are_refused_by_name() {
    let text = draco(CONNECTED, &[("POSITION", POSITION, 0)]);
    let broken = "accessor 0: KHR_draco_mesh_compression: ";
    for (old, new, said) in [
        ("{\"POSITION\": 0}}", "{\"POSITION\": 7}}", &format!("{broken}has no attribute 7")[..]),
        ("VEC3", "VEC2", "type \"VEC2\" does not have 3 numbers"),
        (
            "0, \"byteLength\": 76",
            "0, \"byteLength\": 40",
            &format!("{broken}can't be unpacked")[..],
        ),
        (
            "{\"bufferView\": 0",
            "{\"bufferView\": 9",
            &format!("{broken}view 9 is out of range")[..],
        ),
        (", \"indices\": 1", "", "mesh 0, primitive 0: compressed by the extension KHR_draco_mesh"),
        (
            ", \"attributes\": {\"POSITION\": 0}}}",
            "}}",
            "compressed by the extension KHR_draco_mesh",
        ),
    ] {
        let text = text.replace("\n        ", " ");
        assert!(text.contains(old), "{old}: {text}");
        let refused = refusal(text.replace(old, new).as_bytes(), GLTF).1;
        assert!(refused.contains(said), "{new}: {refused}");
    }
    // Primitives may share a stream, but not the accessors of two streams.
    let two = |view: u32| {
        let second = r#""bufferViews": [{"buffer": 0, "byteLength": 76}, "#;
        let text = text.replace("\"bufferViews\": [", second);
        let (head, primitive) = text.split_once("\"primitives\": [").unwrap();
        let primitive = primitive.strip_suffix("]}]}").unwrap();
        let other = primitive.replace("\"bufferView\": 0", &format!("\"bufferView\": {view}"));
        format!("{head}\"primitives\": [{primitive}, {other}]}}]}}")
    };
    assert_eq!(read_bytes(two(0).as_bytes(), GLTF).unwrap().mesh.faces().len(), 4);
    let refused = refusal(two(1).as_bytes(), GLTF).1;
    assert!(refused.contains("is packed in two views"), "{refused}");
    // No change of a byte stops the reader.
    for (stream, id) in [(CONNECTED, 0), (LISTED, 3)] {
        let bytes = STANDARD.decode(stream).unwrap();
        for at in 0..bytes.len() {
            for bit in 0..8 {
                let mut bytes = bytes.clone();
                bytes[at] ^= 1 << bit;
                let text = draco(&STANDARD.encode(bytes), &[("POSITION", POSITION, id)]);
                let _ = read_bytes(text.as_bytes(), GLTF);
            }
        }
    }
}

/// The square of [`SQUARE`] in views that are packed, in a buffer that the file does not have.
fn packed_square() -> String {
    let positions = &square_bytes()[..48];
    // One block of one group, with the differences of bytes as they are.
    let mut bytes = vec![0xa0];
    for k in 0..12 {
        let mut deltas = [0u8; 16];
        for (v, delta) in deltas.iter_mut().enumerate().take(4).skip(1) {
            let change = positions[12 * v + k].wrapping_sub(positions[12 * (v - 1) + k]);
            *delta = (change << 1) ^ (change >> 7).wrapping_neg();
        }
        bytes.push(3);
        bytes.extend(deltas);
    }
    // The first element is zero.
    bytes.extend([0; 32]);
    let first = bytes.len();
    // The differences 0, 1, 1, 0, -1 and 2 of the numbers of vertices.
    bytes.extend([0xd1, 0, 4, 4, 0, 2, 8, 0, 0, 0, 0]);
    let (size, data) = (bytes.len(), STANDARD.encode(&bytes));
    let second = size - first;
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "extensionsUsed": ["EXT_meshopt_compression"],
        "extensionsRequired": ["EXT_meshopt_compression"],
        "buffers": [
            {{"byteLength": {size}, "uri": "data:application/octet-stream;base64,{data}"}},
            {{"byteLength": 60, "extensions": {{"EXT_meshopt_compression": {{"fallback": true}}}}}}
        ],
        "bufferViews": [
            {{"buffer": 1, "byteLength": 48, "extensions": {{"EXT_meshopt_compression":
            {{"buffer": 0, "byteLength": {first}, "byteStride": 12, "count": 4,
            "mode": "ATTRIBUTES"}}}}}},
            {{"buffer": 1, "byteOffset": 48, "byteLength": 12,
            "extensions": {{"EXT_meshopt_compression": {{"buffer": 0, "byteOffset": {first},
            "byteLength": {second}, "byteStride": 2, "count": 6, "mode": "INDICES"}}}}}}
        ],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4}},
            {{"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 6}}],
        "meshes": [{{"primitives": [{PRIMITIVE}]}}]}}"#
    )
}

#[test]
fn views_that_meshopt_packs_are_unpacked_and_broken_ones_refused() {
    let text = packed_square();
    let file = read_bytes(text.as_bytes(), GLTF).unwrap_or_else(|e| panic!("{e}"));
    let plain = read_square(NONE, "");
    assert_eq!((&file.mesh, &file.notes), (&plain.mesh, &plain.notes));
    for (old, new, said) in [
        ("INDICES", "OTHER", "view 1: unknown mode \"OTHER\""),
        ("INDICES", "TRIANGLES", "view 1: begins with byte 0xd1"),
        ("ATTRIBUTES\"", "ATTRIBUTES\", \"filter\": \"COLOR\"", "view 0: unknown filter \"COLOR\""),
        ("12, \"count\": 4", "12, \"count\": 5", "does not have the size of 5 packed elements"),
        ("12, \"count\": 4", "12, \"count\": 8888888888888888", "the buffers would take"),
        ("{\"buffer\": 0, \"byteLength\"", "{\"buffer\": 1, \"byteLength\"", "bytes are beyond"),
        ("48, \"extensions\"", "48, \"extras\"", "view 0 is beyond its buffer, which has 0 bytes"),
    ] {
        assert!(text.contains(old), "{old}");
        let refused = refusal(text.replace(old, new).as_bytes(), GLTF).1;
        assert!(refused.contains(said), "{refused}");
    }
    // A view that no mesh has may be broken.
    let unused =
        text.replace("\"bufferView\": 1, \"componentType\": 5123", "\"componentType\": 5123");
    assert!(read_bytes(unused.replace("INDICES", "OTHER").as_bytes(), GLTF).is_ok());
}

#[test]
fn extensions_that_are_left_out_are_named_with_their_objects() {
    let own = r#""extensions": {"FOO_bar": {"a": [1, {}]}}"#;
    for (change, more, place) in [
        (("\"indices\": 1}", &*format!("\"indices\": 1, {own}}}")), "", "mesh 0, primitive 0"),
        (("\"primitives\"", &*format!("{own}, \"primitives\"")), "", "mesh 0"),
        (("\"count\": 6", &*format!("\"count\": 6, {own}")), "", "accessor 1"),
        (("\"byteLength\": 6", &*format!("\"byteLength\": 6, {own}")), "", "buffer view 1"),
        (NONE, &*format!(", {own}"), "the document"),
        (
            NONE,
            &*format!(r#", "scenes": [{{"nodes": [0], {own}}}], "nodes": [{{"mesh": 0}}]"#),
            "scene 0",
        ),
        (
            NONE,
            &*format!(r#", "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0, {own}}}]"#),
            "node 0",
        ),
    ] {
        let file = read_square(change, more);
        let said = "left out the extension FOO_bar, which is not supported: 1, the first at ";
        assert_eq!(file.notes, [format!("{said}{place}")]);
        assert_eq!(file.mesh.area(), 1.0);
        let harmless = |text: &str| text.replace("FOO_bar", "KHR_materials_unlit");
        let file = read_square((change.0, &harmless(change.1)), &harmless(more));
        assert!(file.notes.is_empty(), "{place}: {:?}", file.notes);
    }
}

#[test]
fn instances_of_a_mesh_are_all_there() {
    let document = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "translation": [0, 0, 7],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2,
        "ROTATION": 3, "SCALE": 4, "_ID": 2}}}}]"#;
    let half = 0.5f32.sqrt();
    let accessors: [(&str, &[f32]); 3] = [
        ("VEC3", &[0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 20.0, 0.0, 0.0]),
        ("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half, 0.0, 0.0, 0.0, 1.0]),
        ("VEC3", &[1.0, 1.0, 1.0, 2.0, 1.0, 1.0, -1.0, 3.0, 1.0]),
    ];
    let file = read_bytes(&with_floats(document, &accessors), GLB).unwrap();
    assert_eq!((file.mesh.vertices().len(), file.mesh.faces().len()), (12, 6));
    assert!((file.mesh.area() - 6.0).abs() < 1e-12, "{}", file.mesh.area());
    assert_eq!(file.notes, [""; 0]);
    assert!(file.mesh.face_normals().iter().all(|n| n[2] > 0.99));
    // The second one is stretched, then turned by a right angle, then moved.
    let far = file.mesh.vertices()[5];
    let near = (0..3).all(|k| (far[k] - [10.0, 2.0, 7.0][k]).abs() < 1e-12);
    assert!(near, "{far:?}");
    let uneven = [accessors[0], accessors[1], ("VEC3", &[1.0f32; 6][..])];
    let said = refusal(&with_floats(document, &uneven), GLB).1;
    assert_eq!(said, "node 0: EXT_mesh_gpu_instancing: attributes of different counts");
    // A count without numbers takes no memory.
    let huge = square(
        (
            "\"count\": 6}",
            r#""count": 6}, {"componentType": 5126, "type": "VEC3",
        "count": 99999999999}"#,
        ),
        r#", "nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes":
        {"TRANSLATION": 2}}}}]"#,
    );
    let said = refusal(&huge, GLB).1;
    assert!(said.starts_with("node 0: ") || said.contains("of memory"), "{said}");
}

#[test]
fn morph_targets_move_vertices_by_the_weights_of_the_node_or_the_mesh() {
    let document = |mesh: &str, node: &str| {
        format!(
            r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1,
            "targets": [{{"POSITION": 2}}, {{"POSITION": 3, "COLOR_0": 3}}]}}]{mesh}}}],
            "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0{node}}}]"#
        )
    };
    let up = [0.0, 0.0, 1.0].repeat(4);
    // The far corners move so that the square is twice as wide.
    let wide = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    let accessors: [(&str, &[f32]); 2] = [("VEC3", &up), ("VEC3", &wide)];
    let left_out = "left out morph targets, whose weight is 0: ";
    for (mesh, node, area, height, unused) in [
        ("", "", 1.0, 0.0, 2),
        (r#", "weights": [3, 1]"#, "", 2.0, 3.0, 0),
        (r#", "weights": [3, 1]"#, r#", "weights": [0, 0.5]"#, 1.5, 0.0, 1),
        (r#", "weights": [3, 1]"#, r#", "weights": [-2]"#, 1.0, -2.0, 1),
    ] {
        let file = read_bytes(&with_floats(&document(mesh, node), &accessors), GLB).unwrap();
        let found = (file.mesh.area(), file.mesh.vertices()[0][2]);
        assert_eq!(found, (area, height), "{mesh}{node}");
        let said = file.notes.iter().find_map(|line| line.strip_prefix(left_out));
        assert_eq!(said.map(|said| &said[..1]), (unused > 0).then_some(&*unused.to_string()));
        let colors = file.notes.iter().any(|line| line.starts_with("left out colours of morph"));
        assert_eq!(colors, area != 1.0);
    }
    let wrong = with_floats(&document(r#", "weights": [1, 1, 1]"#, ""), &accessors);
    let said = refusal(&wrong, GLB).1;
    assert_eq!(said, "mesh 0, primitive 0: 3 weights of 2 morph targets");
    let short: [(&str, &[f32]); 2] = [("VEC3", &up[..9]), ("VEC3", &wide)];
    let said = refusal(&with_floats(&document(r#", "weights": [1]"#, ""), &short), GLB).1;
    assert!(said.ends_with("a morph target has 3 values, not 4"), "{said}");
}

#[test]
fn the_node_of_a_skinned_mesh_does_not_place_it() {
    let nodes = r#", "skins": [{"joints": [1]}], "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "skin": 0, "scale": [10, 10, 10], "children": [2]},
        {}, {"mesh": 0, "translation": [1, 1, 1]}]"#;
    let file = read_square(NONE, nodes);
    assert_eq!(file.mesh.area(), 1.0 + 100.0);
    assert_eq!(file.mesh.vertices()[7], [20.0, 20.0, 10.0]);
    let said = "read skinned meshes as they are modelled, without the pose of their joints: 1, \
                the first at node 0";
    assert_eq!(file.notes, [said]);
}

#[test]
fn nodes_and_meshes_that_are_not_shown_are_counted() {
    let hidden = r#", "scenes": [{"nodes": [0, 1]}], "nodes": [{"mesh": 0}, {"children": [2, 3],
        "extensions": {"KHR_node_visibility": {"visible": false}}}, {"mesh": 0}, {"mesh": 0,
        "extensions": {"KHR_node_visibility": {"visible": true}}}]"#;
    let file = read_square(NONE, hidden);
    assert_eq!(file.mesh.faces().len(), 2);
    let said = "left out hidden nodes (KHR_node_visibility): 2, the first at node 2";
    assert_eq!(file.notes, [said]);

    // The default scene is the second; a mesh that no node has.
    let two = r#", "scene": 1, "scenes": [{"nodes": [0]}, {"nodes": [1]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "scale": [2, 2, 2]}, {"mesh": 0}]"#;
    let meshes = "\"meshes\": [{\"primitives\": []}, ";
    let file = read_square(("\"meshes\": [", meshes), &two.replace("\"mesh\": 0", "\"mesh\": 1"));
    assert_eq!(file.mesh.area(), 4.0);
    let said = [
        "left out nodes with meshes that are not in the scene: 2, the first at node 0",
        "left out meshes that no node has: 1, the first at mesh 0",
    ];
    assert_eq!(file.notes, said);

    // Without a scene, the nodes still place their meshes.
    let nodes = r#", "nodes": [{"mesh": 0}, {"scale": [3, 3, 3], "children": [0]}]"#;
    let file = read_square(NONE, nodes);
    assert_eq!((file.mesh.area(), &file.notes[..]), (9.0, &[][..]));
    let wrong = nodes.replace("[0]", "[7]");
    assert_eq!(refusal(&square(NONE, &wrong), GLB).1, "no node 7");
}

#[test]
fn quantized_positions_are_placed_by_their_node() {
    let scene = r#", "extensionsRequired": ["KHR_mesh_quantization"], "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "scale": [32767, 32767, 1], "translation": [5, 0, 0]}]"#;
    for (component, normalized, one) in
        [(5122, true, 32767.0), (5122, false, 32767.0), (5120, true, 127.0)]
    {
        let width = if component == 5122 { 2 } else { 1 };
        let mut bytes = Vec::new();
        for [x, y] in [[0i16, 0], [one as i16, 0], [0, one as i16], [one as i16, one as i16]] {
            // Padded to four components.
            for value in [x, y, 0, 0] {
                bytes.extend(&value.to_le_bytes()[..width]);
            }
        }
        let stride = 4 * width;
        bytes.resize(48, 0);
        bytes.extend([0, 1, 2, 2, 1, 3]);
        let document = SQUARE
            .replace("\"byteLength\": 48", &format!("\"byteLength\": 48, \"byteStride\": {stride}"))
            .replace("5126", &format!("{component}, \"normalized\": {normalized}"));
        let file = read_bytes(&gltf(&format!("{document}{scene}"), &bytes), GLB).unwrap();
        let unit = if normalized { 32767.0 } else { 32767.0 * one };
        assert_eq!(file.mesh.vertices()[3], [5.0 + unit, unit, 0.0], "{component}");
        assert!(file.notes.is_empty());
    }
}

#[test]
fn primitives_that_are_no_triangles_are_counted() {
    let and = |more: &str| format!("{PRIMITIVE}, {more}, {more}");
    let points = and(r#"{"attributes": {"POSITION": 0}, "mode": 0}"#);
    let file = read_square((PRIMITIVE, &points), "");
    note(&file, "read points as vertices without a face: primitives: 2, the first at mesh 0, pri");
    for mode in 1..4 {
        let lines = and(&format!(r#"{{"attributes": {{"POSITION": 0}}, "mode": {mode}}}"#));
        let file = read_square((PRIMITIVE, &lines), "");
        assert_eq!(
            file.notes,
            ["left out primitives of lines: 2, the first at mesh 0, primitive 1"]
        );
    }
    let unknown = square(("\"indices\": 1", "\"mode\": 9"), "");
    assert_eq!(refusal(&unknown, GLB).1, "mesh 0, primitive 0: unknown mode 9");
    let without = and(r#"{"attributes": {"NORMAL": 0}}"#);
    let file = read_square((PRIMITIVE, &without), "");
    note(&file, "left out primitives without positions: 2, the first at mesh 0, primitive 1");
    // A strip that is turned by a vertex twice: 0 1 2 2 1 3.
    let file = read_square(("\"indices\": 1", "\"indices\": 1, \"mode\": 5"), "");
    assert_eq!(file.mesh.faces(), [[0, 1, 2], [1, 2, 3]]);
    assert!(file.notes.is_empty() && file.mesh.area() == 1.0);
    let more = (
        "{\"POSITION\": 0}",
        "{\"POSITION\": 0, \"TEXCOORD_1\": 0, \"_HEAT\": 0, \"JOINTS_0\": 0}",
    );
    let said = |name| {
        format!("left out the attribute {name} of primitives: 1, the first at mesh 0, primitive 0")
    };
    assert_eq!(read_square(more, "").notes, ["TEXCOORD_1", "_HEAT"].map(said));
}

#[test]
fn triangles_with_a_vertex_twice_are_at_the_primitive_that_has_them() {
    let primitives = r#""meshes": [{"primitives": [
        {"attributes": {"POSITION": 2, "COLOR_0": 3}},
        {"attributes": {"POSITION": 4, "COLOR_0": 5}}]}]"#;
    let corners = |x: f32| [x, 0.0, 0.0, x, 0.0, 0.0, x + 1.0, 0.0, 0.0];
    let (red, green) = ([1.0f32, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]);
    // Two corners of the first primitive are in one place, but of different colours.
    let (different, same) = ([red, green, red], [red; 3]);
    let accessors: [(&str, &[f32]); 4] = [
        ("VEC3", &corners(0.0)),
        ("VEC4", different.as_flattened()),
        ("VEC3", &corners(5.0)),
        ("VEC4", same.as_flattened()),
    ];
    let file = read_bytes(&with_floats(primitives, &accessors), GLB).unwrap();
    assert_eq!((file.mesh.faces(), file.collapsed_faces), (&[[0, 1, 2]][..], 1));
    assert_eq!(file.first_collapsed, "mesh 0, primitive 1");
    let said = note(&file, "left out triangles that have a vertex twice");
    assert!(said.ends_with(": 1, the first at mesh 0, primitive 1"), "{said}");
}

#[test]
fn numbers_of_vertices_that_are_not_whole_are_refused() {
    let whole = SQUARE.replace(
        r#""componentType": 5121, "type": "SCALAR", "count": 6"#,
        r#""componentType": 5126, "type": "SCALAR", "count": 3"#,
    );
    let mut bytes = square_bytes();
    bytes.truncate(48);
    bytes.extend([0f32, 0.5, 2.0].iter().flat_map(|x| x.to_le_bytes()));
    let document = whole.replace("\"byteLength\": 6", "\"byteLength\": 12");
    let said = refusal(&gltf(&document, &bytes), GLB).1;
    assert!(said.contains("vertex 0.5 is out of range: 4 vertices"), "{said}");
    let newer = r#"{"asset": {"version": "2.0", "minVersion": "2.1"}}"#;
    let said = refusal(newer.as_bytes(), MeshFormat::Gltf(GltfEncoding::Text)).1;
    assert!(said.starts_with("needs version \"2.1\""), "{said}");
}

#[test]
fn gltf_files_of_other_programs_are_read_as_they_say() {
    let Some(path) = data("inputs/meshes/gltf_skin_nodexform.gltf") else { return };
    let file = read(&path).unwrap();
    assert!((file.mesh.volume().unwrap() - 1.0).abs() < 1e-12);
    note(&file, "read skinned meshes as they are modelled");
    let Some(path) = data("inputs/meshes/gltf_unknown_required.gltf") else { return };
    assert!(read(&path).unwrap_err().to_string().contains("requires the extension FOO_bar"));
}
