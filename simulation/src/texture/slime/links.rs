use super::kinds::{BORDER, INSIDE};
use super::locate::{anchor, texel};
use super::surface::{NO_TRIANGLE, Surface, UV};
use super::walk::{Walker, unfold};
use catamaran::base::Result;

/// The texels at seams, and the texels with which each exchanges pheromone, in compressed rows.
#[derive(Debug, Clone)]
pub(super) struct Links {
    pub texels: Vec<u32>,
    pub starts: Vec<u32>,
    pub links: Vec<u32>,
    pub weights: Vec<f32>,
}

/// Largest share of its pheromone that a texel gives away, so that no value leaves `[0, 1]`.
const MOST: f64 = 15.0 / 16.0;

/// The steps to the surrounding texels, and their weights in the kernel.
const AROUND: [([i32; 2], f64); 8] = [
    ([-1, -1], 1.0 / 16.0),
    ([0, -1], 2.0 / 16.0),
    ([1, -1], 1.0 / 16.0),
    ([-1, 0], 2.0 / 16.0),
    ([1, 0], 2.0 / 16.0),
    ([-1, 1], 1.0 / 16.0),
    ([0, 1], 2.0 / 16.0),
    ([1, 1], 1.0 / 16.0),
];

/// Finds the texels at borders, sets `kinds`, and links texels across seams: where the kernel
/// covers a texel of another chart, its neighbour is found by walking on the surface. The weights
/// of both directions are averaged, so that the exchange keeps the sum.
pub(super) fn links(
    surface: &Surface,
    size: usize,
    owners: &[u32],
    kinds: &mut [u8],
) -> Result<Links> {
    let chart = |t: usize| match owners[t] {
        NO_TRIANGLE => NO_TRIANGLE,
        owner => surface.charts()[owner as usize],
    };
    let neighbour = |t: usize, [di, dj]: [i32; 2]| {
        let at = |x: usize, d: i32| x.checked_add_signed(d as isize).filter(|&x| x < size);
        Some(at(t / size, dj)? * size + at(t % size, di)?)
    };
    let plain = |t: usize, step: [i32; 2]| neighbour(t, step).filter(|&n| chart(n) == chart(t));
    // Links across seams in both directions: (from, to, half of the weight).
    let mut over: Vec<(u32, u32, f64)> = Vec::new();
    for t in (0..owners.len()).filter(|&t| owners[t] != NO_TRIANGLE) {
        kinds[t] = INSIDE;
        for (step, weight) in AROUND {
            if plain(t, step).is_some() {
                continue;
            }
            kinds[t] = BORDER;
            let end = beyond(surface, size, owners[t], t, step);
            let to = texel(surface, size as u32, &end) as usize;
            if to != t && owners[to] != NO_TRIANGLE {
                over.push((t as u32, to as u32, weight / 2.0));
                over.push((to as u32, t as u32, weight / 2.0));
            }
        }
    }
    for &(t, ..) in &over {
        kinds[t as usize] = BORDER;
    }
    // Sorted by pair. The sort is stable, so that the parts of a pair keep their order.
    over.sort_by_key(|&(from, to, _)| (from, to));
    let texels: Vec<u32> =
        (0..owners.len() as u32).filter(|&t| kinds[t as usize] == BORDER).collect();
    let within = |t: u32| {
        AROUND.into_iter().filter_map(move |(step, w)| Some((plain(t as usize, step)? as u32, w)))
    };
    let row = |t: u32| {
        let first = over.partition_point(|link| link.0 < t);
        over[first..].iter().take_while(move |link| link.0 == t)
    };
    // The share of the exchange across seams that a texel can take.
    let share: Vec<f64> = texels
        .iter()
        .map(|&t| {
            let free = MOST - within(t).map(|(_, w)| w).sum::<f64>();
            let wanted: f64 = row(t).map(|link| link.2).sum();
            if wanted > free { free / wanted } else { 1.0 }
        })
        .collect();
    let share_of = |t: u32| texels.binary_search(&t).map_or(1.0, |at| share[at]);
    let mut found =
        Links { texels: Vec::new(), starts: vec![0], links: Vec::new(), weights: Vec::new() };
    for (&t, &own) in texels.iter().zip(&share) {
        let over = row(t).map(|&(_, to, w)| (to, w * own.min(share_of(to))));
        for (to, w) in within(t).chain(over) {
            found.links.push(to);
            found.weights.push(w as f32);
        }
        found.starts.push(found.links.len() as u32);
    }
    found.texels = texels;
    Ok(found)
}

/// Returns the position reached by a step of that many texels in the texture, taken on the surface,
/// from the centre of texel t, or from the point of the triangle nearest to it.
pub(super) fn beyond(
    surface: &Surface,
    size: usize,
    triangle: u32,
    t: usize,
    [di, dj]: [i32; 2],
) -> Walker {
    let record = &surface.records()[triangle as usize];
    let [a, b, c, d] = [UV + 1, UV + 2, UV + 4, UV + 5].map(|i| f64::from(record[i]));
    let determinant = a * d - b * c;
    let (u, v) = (f64::from(di) / size as f64, f64::from(dj) / size as f64);
    let step = [(d * u - b * v) / determinant, (a * v - c * u) / determinant];
    let length = step[0].hypot(step[1]);
    let walker = Walker {
        triangle,
        position: anchor(surface, size, triangle, t),
        heading: step.map(|x| (x / length) as f32),
    };
    unfold(surface, walker, length as f32, true)
}
