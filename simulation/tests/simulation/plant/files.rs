//! Plants of the reference implementation.

use catamaran::Par;
use catamaran_simulation::plant::*;

#[test]
fn real_plants_are_read_and_lose_their_water_slowly() {
    let expected = [
        ("000", 1964, 1692, 0),
        ("001", 617, 452, 0),
        ("002", 300, 263, 0),
        ("003", 711, 564, 0),
        ("006", 8961, 6889, 246),
    ];
    for (number, nodes, leaves, pinned) in expected {
        let name = format!("plants/plant{number}.txt");
        let Some(path) = crate::common::data(&name) else { continue };
        let plant = read(&path).unwrap();
        let count = |f: &dyn Fn(&Segment) -> bool| plant.segments().iter().filter(|s| f(s)).count();
        assert_eq!(
            (plant.len(), count(&|s| s.leaf), count(&|s| s.pinned)),
            (nodes, leaves, pinned)
        );
        let model = WaterModel::new(&plant, &WaterOptions::default()).unwrap();
        let full = model.full();
        let options = CurveOptions::default();
        let times: Vec<f64> = (0..4).map(|i| f64::from(i) * 7200.0).collect();
        let curve = water_curve(&model, &full, &times, &options).unwrap();
        let totals: Vec<f64> = curve.iter().map(|water| water.iter().sum()).collect();
        assert!(totals.windows(2).all(|t| t[1] < t[0] && t[1] > 0.0), "{totals:?}");
        // A reset starts from the beginning: the reference's history survives it, and its water
        // jumps.
        let start = || Bdf6::new(&model, &full, 600.0, Start::Constant, Par::Seq).unwrap();
        let mut bdf = start();
        (0..40).for_each(|_| bdf.step());
        let mut again = start();
        again.step();
        let total: f64 = again.water().iter().sum();
        assert!(total < totals[0] && total > 0.9 * totals[0]);
    }
}
