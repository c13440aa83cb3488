//! Cut and weakened connections.

use catamaran::Par;
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::*;

/// The nodes on and beyond `node`, and the two plants that a cut before it makes, with the nodes
/// they have.
fn parted(plant: &Plant, node: usize) -> [(Plant, Vec<usize>); 2] {
    let mut beyond = vec![false; plant.len()];
    beyond[node] = true;
    // Parents of a grown plant come first.
    for v in node + 1..plant.len() {
        beyond[v] = plant.parent(v).is_some_and(|p| beyond[p]);
    }
    [false, true].map(|side| {
        let nodes: Vec<usize> = (0..plant.len()).filter(|&v| beyond[v] == side).collect();
        let mut numbers = vec![None; plant.len()];
        nodes.iter().enumerate().for_each(|(i, &v)| numbers[v] = Some(i as u32));
        let segments = nodes.iter().map(|&v| plant.segments()[v]).collect();
        let parents: Vec<_> =
            nodes.iter().map(|&v| plant.parent(v).and_then(|p| numbers[p])).collect();
        (Plant::new(segments, &parents, Some(plant.head(nodes[0]))).unwrap(), nodes)
    })
}

#[test]
fn a_cut_plant_is_two_plants_bit_for_bit() {
    // The larger one has a trunk that threads share, and loses it by the cut.
    for (nodes, node) in [(200, 40), (12_000, 24)] {
        let plant = grow(&GrowthOptions::new().nodes(nodes)).unwrap();
        let options = WaterOptions::default();
        let mut model = WaterModel::new(&plant, &options).unwrap();
        model.cut(node).unwrap();
        let solve = |model: &WaterModel| {
            let full = model.full();
            let mut bdf = Bdf6::new(model, &full, 900.0, Start::Radau, Par::Threads(2)).unwrap();
            (0..9).for_each(|_| bdf.step());
            (bdf.water(), model.water_after(&full, 900.0, Par::Threads(2)).unwrap())
        };
        let whole = solve(&model);
        for (part, nodes) in parted(&plant, node) {
            assert!(part.len() > 1);
            let alone = solve(&WaterModel::new(&part, &options).unwrap());
            let of_whole = |water: &[f64]| nodes.iter().map(|&v| water[v]).collect::<Vec<_>>();
            assert_eq!(of_whole(&whole.0), alone.0);
            assert_eq!(of_whole(&whole.1), alone.1);
        }
    }
}

#[test]
fn a_leaf_dries_beyond_a_cut_and_less_where_the_stem_is_weak() {
    let plant = grow(&GrowthOptions::new().nodes(300)).unwrap();
    let model = WaterModel::new(&plant, &WaterOptions::default()).unwrap();
    let is_leaf = |v: usize| plant.segments()[v].leaf;
    let begins = |v: &usize| is_leaf(*v) && plant.parent(*v).is_some_and(|p| !is_leaf(p));
    let beyond = |v: &usize| parted(&plant, *v)[1].1.clone();
    let node = (0..300).filter(begins).max_by_key(|v| beyond(v).len()).unwrap();
    let mut cut = model.clone();
    cut.cut(node).unwrap();
    let mut weak = model.clone();
    weak.weaken(node, 0.05).unwrap();
    let leaf = beyond(&node);
    let left = |model: &WaterModel| {
        let water = model.water_after(&model.full(), 2e4, Par::Seq).unwrap();
        leaf.iter().map(|&v| water[v]).sum::<f64>()
    };
    let [healthy, weak, cut] = [&model, &weak, &cut].map(left);
    assert!(healthy > 1.05 * cut && weak < healthy && weak > cut, "{healthy} {weak} {cut}");
}
