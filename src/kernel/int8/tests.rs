//! One suite for every kernel, against integers of any size.

#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
mod emulator;
mod ladder;

use super::direct::MOST_ROWS;
use super::moduli::Modulus;
use super::sealed::Steps;
use super::tile::{self, Quarter, power_of_two};
use super::*;
use crate::base::Rng;

/// The kernel that the others are compared with.
pub(crate) static PORTABLE: portable::Portable = portable::Portable;

/// Returns every kernel that can run here, with its name. Without AMX, Linux with AVX-512 VNNI
/// emulates it, and without AVX-VNNI, AVX2 emulates that.
pub(crate) fn kernels() -> Vec<(&'static str, &'static dyn Kernel)> {
    #[allow(unused_mut)]
    let mut found: Vec<(&'static str, &'static dyn Kernel)> = vec![("portable", &PORTABLE)];
    #[cfg(target_arch = "aarch64")]
    for isa in [IntegerIsa::Dotprod, IntegerIsa::I8mm] {
        match isa.refusal() {
            None => found.push((isa.name(), isa.kernel())),
            Some(why) => println!("skipped: {}, {why}", isa.name()),
        }
    }
    #[cfg(target_arch = "x86_64")]
    {
        if let Ok(kernel) = avx2::Avx2::new() {
            found.push(("avx2", kernel));
        }
        if let Ok(kernel) = dots::kernel().or_else(|_| dots::emulated_kernel()) {
            found.push(("avxvnni", kernel));
        }
        if let Ok(kernel) = avx512::Vnni::new() {
            found.push(("vnni", kernel));
        } else {
            println!(
                "skipped: no AVX-512 with VNNI, so its kernel and that for AMX are not tested"
            );
        }
        match amx::Amx::new() {
            Ok(kernel) => found.push(("amx", kernel)),
            #[cfg(target_os = "linux")]
            Err(_) => {
                if let Ok(kernel) = emulator::amx() {
                    found.push(("amx", kernel));
                }
            }
            #[cfg(not(target_os = "linux"))]
            Err(_) => {}
        }
    }
    found
}

fn byte(rng: &mut Rng) -> i8 {
    // Extremes are frequent, since they overflow sums.
    match rng.bits() % 8 {
        0 => i8::MIN,
        1 => i8::MAX,
        _ => rng.bits() as i8,
    }
}

fn slices(count: usize, rng: &mut Rng) -> Vec<Slice> {
    (0..count).map(|_| [[(); STEP * WIDTH]; 2].map(|tile| tile.map(|()| byte(rng)))).collect()
}

/// Returns the entry of row `k` and column `j` of a panel.
fn entry(panel: &[Slice], k: usize, j: usize) -> i64 {
    let tile = &panel[k / STEP][j / WIDTH];
    tile[64 * (k % STEP / 4) + 4 * (j % WIDTH) + k % 4].into()
}

fn place<T: Copy>(block: &PanelBlock<T>, i: usize, j: usize) -> T {
    block[2 * (i / WIDTH) + j / WIDTH][i % WIDTH][j % WIDTH]
}

/// Checks the products of the panels in `left`, one after another, with `right`, plus the residues
/// `old` if `continued`.
fn check_product(
    (name, kernel): (&str, &dyn Kernel),
    modulus: &Modulus,
    [left, right]: [&[Slice]; 2],
    old: &[PanelBlock<i8>],
    continued: bool,
) {
    let steps = right.len();
    let mut moved = left.to_vec();
    kernel.to_left(left, &mut moved);
    let mut residues = old.to_vec();
    {
        let _session = kernel.session();
        let operands = Operands { left: &moved, right, next: right, modulus, continued };
        kernel.product(&operands, &mut residues);
    }
    for (panel, (residues, old)) in residues.iter().zip(old).enumerate() {
        let left = &left[panel * steps..][..steps];
        for i in 0..PANEL {
            for j in 0..PANEL {
                let product = |k| entry(left, k, i) * entry(right, k, j);
                let before = if continued { place(old, i, j).into() } else { 0 };
                let sum = before + (0..STEP * steps).map(product).sum::<i64>();
                let p = i64::from(modulus.p);
                assert_eq!(
                    i64::from(place(residues, i, j)).rem_euclid(p),
                    sum.rem_euclid(p),
                    "{name}, {steps} steps, panel {panel}, ({i}, {j}), {sum} mod {p}"
                );
            }
        }
    }
}

#[test]
fn products_are_those_of_the_definition() {
    let mut rng = Rng::new(1);
    let moduli = Moduli::of(15);
    for named in kernels() {
        for (l, (steps, panels)) in
            [(0, 1), (1, 1), (2, 3), (7, 2), (DEPTH, 2), (3, 0)].into_iter().enumerate()
        {
            let (left, right) = (slices(panels * steps, &mut rng), slices(steps, &mut rng));
            let old: Vec<PanelBlock<i8>> = (0..panels)
                .map(|_| {
                    [(); 4].map(|()| [(); WIDTH].map(|()| [(); WIDTH].map(|()| byte(&mut rng))))
                })
                .collect();
            let modulus = &moduli.list[2 * l];
            for continued in [false, true] {
                check_product(named, modulus, [&left, &right], &old, continued);
            }
        }
    }
}

#[test]
fn the_largest_sums_are_reduced_by_every_modulus() {
    for named in kernels() {
        for (sign, value) in [(1, i8::MIN), (-1, i8::MAX)] {
            // Every product 2^14, or about -2^14.
            let left = vec![[[i8::MIN; STEP * WIDTH]; 2]; DEPTH];
            let right = vec![[[value; STEP * WIDTH]; 2]; DEPTH];
            let old = [[[[if sign > 0 { i8::MAX } else { i8::MIN }; WIDTH]; WIDTH]; 4]];
            for modulus in &IntegerModuli::new(MOST_MODULI).list {
                check_product(named, modulus, [&left, &right], &old, true);
            }
        }
    }
}

/// Returns random entries of all sizes up to 2^INTEGER_BITS, among them zeros and ties of rounding.
fn tile<T: IntegerOperand>(rng: &mut Rng) -> Tile<T> {
    let mut tile = Tile::zeros();
    for (i, row) in tile.0.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            let bits = (7 * i + j) as i32 % (T::INTEGER_BITS + 2);
            *value = T::from_f64(match rng.bits() % 16 {
                0 => 0.0,
                1 => rng.sign() * 0.5,
                2 => rng.sign() * 1.5,
                3 => rng.sign() * 2.5,
                4 => rng.sign() * power_of_two(bits.min(T::INTEGER_BITS) - 1),
                _ => rng.sign() * rng.uniform() * power_of_two(bits.min(T::INTEGER_BITS)),
            });
        }
    }
    tile
}

fn check_conversion<T: IntegerOperand>() {
    let mut rng = Rng::new(2);
    let whole: Tile<T> = tile(&mut rng);
    let exponents: [i32; WIDTH] = std::array::from_fn(|j| 5 * j as i32 - 40);
    let mut scaled = whole.clone();
    for row in &mut scaled.0 {
        for (value, &e) in row.iter_mut().zip(&exponents) {
            *value = T::from_f64(value.to_f64() * power_of_two(-e));
        }
    }
    let powers = Powers::new(exponents);
    for (name, kernel) in kernels() {
        for count in [2, 7, 13, 14, 15] {
            let moduli = Moduli::of(count);
            let mut memory = vec![[0; STEP * WIDTH]; count];
            let out = &mut memory.iter_mut().collect::<Vec<_>>();
            let (tile, moduli, far) = (&scaled, &moduli.list[..], count % 2 == 0);
            T::convert(kernel, Conversion { tile, powers: &powers, moduli, out, far });
            for (modulus, residues) in moduli.iter().zip(&memory) {
                for (i, row) in whole.0.iter().enumerate() {
                    for (j, value) in row.iter().enumerate() {
                        let integer = value.to_f64().round_ties_even() as i64;
                        let residue = residues[64 * (i / 4) + 4 * j + i % 4];
                        let p = i64::from(modulus.p);
                        assert_eq!(
                            i64::from(residue).rem_euclid(p),
                            integer.rem_euclid(p),
                            "{name}, {integer} mod {p}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn conversion_rounds_to_even_and_takes_residues() {
    check_conversion::<f64>();
    check_conversion::<f32>();
}

#[test]
fn wide_conversion_takes_residues_of_eighty_bits() {
    let mut rng = Rng::new(5);
    let mut whole = Tile::<f64>::zeros();
    for (i, row) in whole.0.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            let bits = (13 * i + 5 * j) as i32 % (WIDE_BITS + 1);
            *value = match rng.bits() % 8 {
                0 => rng.sign() * power_of_two(WIDE_BITS),
                1 => rng.sign() * (power_of_two(49) + 0.5),
                2 => rng.sign() * (power_of_two(50) * 3.5),
                3 => rng.sign() * 2.5,
                _ => rng.sign() * rng.uniform() * power_of_two(bits),
            };
        }
    }
    let exponents: [i32; WIDTH] = std::array::from_fn(|j| 3 * j as i32 - 20);
    let mut scaled = whole.clone();
    for row in &mut scaled.0 {
        for (value, &e) in row.iter_mut().zip(&exponents) {
            *value *= power_of_two(-e);
        }
    }
    let moduli = IntegerModuli::new(MOST_MODULI);
    let single = Tile(scaled.0.map(|row| row.map(|x| x as f32)));
    let of_single = Tile(single.0.map(|row| row.map(f64::from)));
    for (name, kernel) in kernels() {
        let mut memory = vec![vec![[0; STEP * WIDTH]; MOST_MODULI]; 2];
        let powers = Powers::new(exponents);
        let (powers, list) = (&powers, &moduli.list[..]);
        let out = &mut memory[0].iter_mut().collect::<Vec<_>>();
        let of_double = Conversion { tile: &scaled, powers, moduli: list, out, far: true };
        f64::convert_wide(kernel, of_double);
        let out = &mut memory[1].iter_mut().collect::<Vec<_>>();
        let tile = &single;
        f32::convert_wide(kernel, Conversion { tile, powers, moduli: list, out, far: false });
        for (tile, memory) in [&scaled, &of_single].into_iter().zip(memory) {
            for (modulus, residues) in moduli.list.iter().zip(&memory) {
                for (i, row) in tile.0.iter().enumerate() {
                    for (j, value) in row.iter().enumerate() {
                        let value = value * power_of_two(exponents[j]);
                        let integer = value.round_ties_even() as i128;
                        let residue = residues[64 * (i / 4) + 4 * j + i % 4];
                        let p = i128::from(modulus.p);
                        assert_eq!(
                            i128::from(residue).rem_euclid(p),
                            integer.rem_euclid(p),
                            "{name}, {integer} mod {p}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn integers_of_many_bits_come_back_from_their_residues() {
    let mut rng = Rng::new(6);
    for count in [2, 5, 6, 11, 15, 16, 20, 23, MOST_MODULI] {
        let moduli = IntegerModuli::new(count);
        // Integers as products, since the residues of their factors are easy to compute.
        let most = (IntegerModuli::bits(count) - 1.1) / 2.0;
        let factor = |rng: &mut Rng| {
            let size = (rng.uniform() * power_of_two(most as i32)) as i128;
            rng.sign() as i128 * (size >> (rng.bits() % most as u64))
        };
        let factors: Quarter<[i128; 2]> =
            [(); WIDTH].map(|()| [(); WIDTH].map(|()| [factor(&mut rng), factor(&mut rng)]));
        let residues: Vec<Quarter<i8>> = moduli
            .list
            .iter()
            .map(|m| {
                factors.map(|row| {
                    row.map(|[a, b]| {
                        let p = i128::from(m.p);
                        let r = (a.rem_euclid(p) * b.rem_euclid(p)) % p;
                        (if r > 127 { r - p } else { r }) as i8
                    })
                })
            })
            .collect();
        let residues: Vec<&Quarter<i8>> = residues.iter().collect();
        let mut found = [[I256::default(); WIDTH]; WIDTH];
        integers(&residues, &moduli, &mut found);
        for (found, factors) in found.as_flattened().iter().zip(factors.as_flattened()) {
            assert_eq!(Some(*found), I256::product(factors[0], factors[1]), "{count} moduli");
        }
        if count <= 15 {
            let mut short = [[0_i128; WIDTH]; WIDTH];
            integers(&residues, &moduli, &mut short);
            for (found, [a, b]) in short.as_flattened().iter().zip(factors.as_flattened()) {
                assert_eq!(*found, a * b);
            }
        }
    }
}

/// Returns `v 2^e` rounded, for an integer of up to 126 bits; a subnormal is rounded twice.
fn scaled(v: i128, e: i32) -> f64 {
    let rounded = v as f64;
    rounded * power_of_two(e >> 1) * power_of_two(e - (e >> 1))
}

#[test]
fn numbers_come_back_from_their_residues() {
    for count in [2, 3, 6, 7, 8, 13, 14, 15] {
        let moduli = Moduli::of(count);
        let product: i128 = moduli.list.iter().map(|m| i128::from(m.p)).product();
        let bits = 128 - product.leading_zeros();
        let mut rng = Rng::new(count as u64);
        let mut numbers: PanelBlock<i128> = [[[0; WIDTH]; WIDTH]; 4];
        for number in numbers.as_flattened_mut().as_flattened_mut() {
            let random = (i128::from(rng.bits()) << 64 | i128::from(rng.bits())) & i128::MAX;
            let limit = product / 2 - (product >> 20) - 1;
            *number = match rng.bits() % 8 {
                0 => limit,
                1 => -limit,
                2 => 0,
                // Near the middle between two numbers, where one rounding differs from two.
                4 if bits > 60 => {
                    let middle = i128::from(rng.bits() >> 11 | 1 << 53 | 1) << (bits - 58);
                    middle + i128::from(rng.bits() % 2048) - 1024
                }
                3 => i128::from(rng.bits() % 100) << (rng.bits() % u64::from(bits - 8)),
                _ => (random % limit) >> (rng.bits() % u64::from(bits)),
            } * if rng.sign() > 0.0 { 1 } else { -1 };
            *number = (*number).clamp(-limit, limit);
        }
        // Residues may be any representative that fits a byte.
        let mut residue = |v: i128, m: &Modulus| {
            let r = v.rem_euclid(m.p.into()) as i32;
            let other = r - m.p;
            let swap = rng.sign() > 0.0 && other >= -128;
            (if r > 127 || swap { other } else { r }) as i8
        };
        let residues: Vec<PanelBlock<i8>> = moduli
            .list
            .iter()
            .map(|m| numbers.map(|quarter| quarter.map(|row| row.map(|v| residue(v, m)))))
            .collect();
        let residues: Vec<&PanelBlock<i8>> = residues.iter().collect();
        let rows: [i32; PANEL] = std::array::from_fn(|i| 30 * i as i32 - 600);
        let columns: [i32; PANEL] = std::array::from_fn(|j| 35 * j as i32 - 560);
        // Prefetched addresses may be any.
        let next = Next { residues: usize::MAX, line: std::ptr::dangling(), stride: -7, len: 100 };
        for (name, kernel) in kernels() {
            let mut out: Square<f64> = [[f64::NAN; PANEL]; PANEL];
            let (residues, rows, columns) = (&residues[..], &rows, &columns);
            kernel.recombine(Recombination { residues, moduli, rows, columns, next }, &mut out);
            for i in 0..PANEL {
                for j in 0..PANEL {
                    let number = numbers[i / WIDTH * 2 + j / WIDTH][i % WIDTH][j % WIDTH];
                    let expected = scaled(number, rows[i] + columns[j]);
                    assert_eq!(out[i][j], expected, "{name}, {count} moduli, {number}");
                }
            }
        }
    }
}

/// Returns a strip of integers below `largest`, which are often the largest, or have the largest
/// low part.
fn strip<T: IntegerOperand>(height: usize, largest: f64, rng: &mut Rng) -> Vec<[T; LANES]> {
    let mut entry = |_| {
        let unit = power_of_two(28);
        let value = match rng.bits() % 4 {
            0 => largest,
            1 => ((largest * rng.uniform() / unit).floor() - 0.5) * unit,
            2 => largest * rng.uniform(),
            _ => 1e3 * rng.uniform(),
        };
        T::from_f64((value.round_ties_even() * rng.sign()).clamp(-largest, largest))
    };
    (0..height).map(|_| [(); LANES].map(&mut entry)).collect()
}

/// Products of the columns of two strips, those of a column of the right one together.
struct ProductsOfStrips<'s, T>(&'s [Vec<[T; LANES]>; 2]);

impl<T: IntegerOperand> OnLanes for ProductsOfStrips<'_, T> {
    type Output = [[f64; LANES]; LANES];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> [[f64; LANES]; LANES] {
        let mut both = vec![[0; LANES]; self.0[0].len()];
        let strips = self.0.each_ref().map(|strip| {
            let mut rows = vec![[[0; 2]; LANES]; strip.len()];
            for (row, entries) in rows.iter_mut().zip(strip) {
                let entries = lanes.load(&entries.map(T::to_f64));
                lanes.store_row(lanes.bits(entries), row);
            }
            to_integers::<L, T>(lanes, &mut rows, lanes.splat(1.0), &mut both);
            rows
        });
        let right = |lane| Right { rows: &strips[1], both: &both, lane };
        let mut found = [[0.0; LANES]; LANES];
        for j in 0..5 {
            let products =
                products::<L, T, 4>(lanes, &strips[0], [0, 1, 2, 3].map(|i| right(j + i)));
            for (i, products) in products.into_iter().enumerate() {
                lanes.store(products, &mut found[j + i]);
            }
        }
        for j in [0, 7] {
            let [products] = products::<L, T, 1>(lanes, &strips[0], [right(j)]);
            lanes.store(products, &mut found[j]);
        }
        found
    }
}

/// Checks the products of columns whose norms are nearly `2^bits`.
fn check_strips<T: IntegerOperand>(bits: f64, rng: &mut Rng) {
    for height in [1, 2, 31, MOST_ROWS, MOST_ROWS + 1, 3 * MOST_ROWS + 7] {
        let largest = (bits.exp2() / (height as f64).sqrt()).floor();
        let largest = largest.min(power_of_two(T::INTEGER_BITS) * 0.999);
        let strips = [(); 2].map(|()| strip::<T>(height, largest, rng));
        for (name, kernel) in kernels() {
            let found = kernel.lanes().run(ProductsOfStrips(&strips));
            for (j, found) in found.iter().enumerate() {
                for (i, &value) in found.iter().enumerate() {
                    let rows = strips[0].iter().zip(&strips[1]);
                    let terms = rows.map(|(x, y)| x[i].to_f64() as i128 * y[j].to_f64() as i128);
                    let expected = terms.sum::<i128>() as f64;
                    assert_eq!(value, expected, "{name}, {} {height} ({i}, {j})", T::NAME);
                }
            }
        }
    }
}

#[test]
fn products_of_the_largest_integers_are_exact() {
    let mut rng = Rng::new(58);
    for _ in 0..20 {
        check_strips::<f64>(58.49, &mut rng);
        check_strips::<f32>(31.4, &mut rng);
    }
}

#[test]
fn results_at_the_ends_of_the_range_are_zero_and_infinite() {
    let moduli = Moduli::of(14);
    let residues = vec![&[[[1; WIDTH]; WIDTH]; 4]; moduli.list.len()];
    for (name, kernel) in kernels() {
        for (exponent, expected) in [
            (-2200, 0.0),
            (-1100, 0.0),
            (-1074, 5e-324),
            (1023, power_of_two(1023)),
            (2040, f64::INFINITY),
        ] {
            let mut out = [[f64::NAN; PANEL]; PANEL];
            let half = [exponent / 2; PANEL];
            let rest = [exponent - exponent / 2; PANEL];
            let (residues, rows, columns) = (&residues[..], &half, &rest);
            let it = Recombination { residues, moduli, rows, columns, next: Next::NONE };
            kernel.recombine(it, &mut out);
            assert_eq!(out, [[expected; PANEL]; PANEL], "{name}, 2^{exponent}");
        }
    }
}

#[test]
fn norms_bound_every_column_closely() {
    let mut rng = Rng::new(4);
    let mut tile = Tile::<f64>::zeros();
    for row in &mut tile.0 {
        for (j, value) in row.iter_mut().enumerate() {
            *value = match j {
                0 => 0.0,
                1 => 5e-324 * (rng.bits() % 5) as f64,
                2 => f64::MAX * rng.uniform(),
                _ => rng.normal() * power_of_two(100 * j as i32 - 900),
            };
        }
    }
    tile.0[17][3] = f64::NAN;
    tile.0[63][4] = f64::NEG_INFINITY;
    let expected = portable::Portable.norms_f64(&tile);
    for (name, kernel) in kernels() {
        assert_eq!(kernel.norms_f64(&tile).exponents, expected.exponents, "{name}");
        assert_eq!(kernel.norms_f64(&tile).squares[5..], expected.squares[5..], "{name}");
    }
    assert_eq!(expected.exponents[0], EMPTY);
    assert_eq!((expected.exponents[3], expected.exponents[4]), (NON_FINITE, NON_FINITE));
    for j in [1, 2, 5, 15] {
        let e = expected.exponents[j];
        let column = || tile.0.iter().map(|row| row[j].abs());
        // Scaled in two steps, since one factor may overflow or underflow.
        let unit = |x: f64| x * power_of_two(-e >> 1) * power_of_two(-e - (-e >> 1));
        let largest = column().map(unit).fold(0.0, f64::max);
        assert!((0.5..1.0).contains(&largest), "column {j}: {largest}");
        let exact: f64 = column().map(|x| unit(x).powi(2)).sum();
        let bound = expected.squares[j] / power_of_two(2 * NORM_BITS);
        assert!(bound >= exact && bound <= exact * 1.0001, "column {j}: {bound} for {exact}");
    }
}

#[test]
fn tiles_are_read_from_any_layout_and_padded_with_zeros() {
    use faer::{Mat, MatRef};
    let (m, n) = (70, 19);
    let a = Mat::<f64>::from_fn(m, n, |i, j| (i * 100 + j) as f64);
    let rows: Vec<f64> = (0..m * n).map(|k| (k / n * 100 + k % n) as f64).collect();
    let by_rows = MatRef::from_row_major_slice(&rows, m, n);
    let both_ways = a.as_ref().reverse_rows_and_cols().to_owned();
    let views = [a.as_ref(), by_rows, both_ways.as_ref().reverse_rows_and_cols()];
    let mut tile = Tile([[f64::NAN; WIDTH]; STEP]);
    for view in views {
        for (row, col) in [(0, 0), (64, 0), (0, 16), (64, 16), (0, 32), (128, 0)] {
            tile.load(view, row, col);
            for (i, line) in tile.0.iter().enumerate() {
                for (j, &value) in line.iter().enumerate() {
                    let inside = row + i < m && col + j < n;
                    let expected = if inside { a[(row + i, col + j)] } else { 0.0 };
                    assert_eq!(value, expected, "({row} + {i}, {col} + {j})");
                }
            }
        }
    }
}

#[test]
fn values_of_256_bits_are_scaled_over_the_whole_range() {
    let cases = [
        (power_of_two(250), -1310, power_of_two(-1000) * power_of_two(-60)),
        (-power_of_two(255), -1329, -power_of_two(-1000) * power_of_two(-74)),
        (power_of_two(255), -1331, 0.0),
        (power_of_two(255), -5000, 0.0),
        (power_of_two(-1022), 2000, power_of_two(978)),
        (-1.0, 5000, f64::NEG_INFINITY),
    ];
    for (value, exponent, expected) in cases {
        assert_eq!(tile::scaled(value, exponent), expected, "{value} 2^{exponent}");
    }
}

#[test]
fn a_refused_instruction_set_says_why_and_falls_back() {
    for isa in IntegerIsa::ALL {
        match isa.refusal() {
            None => println!("{}: used", isa.name()),
            Some(why) => assert!(why.len() > 10, "{why}"),
        }
    }
    assert_eq!(IntegerIsa::best().refusal(), None);
    assert_eq!(IntegerIsa::Portable.refusal(), None);
}
