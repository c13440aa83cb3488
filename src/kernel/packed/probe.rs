#[test]
#[ignore]
fn probe() {
    use super::*;
    fn one<T: Operand>() {
        let k = T::kernel(Instance::best());
        let g = k.geometry();
        for steps in [64usize, 128, 192, 256, 384] {
            for (panels, lefts) in [(1usize, 1usize), (4, 4), (10, 10), (20, 3)] {
                let mut ws = crate::base::Workspace::<T>::new((panels + lefts) * steps * g.width + 30 * g.rows * g.width * panels*lefts + 64).unwrap();
                let s = ws.as_mut_slice();
 let o = s.as_ptr().align_offset(64); let s = &mut s[o..];
                s.fill(T::from_f64(1e-3));
                let base = s.as_mut_ptr();
                let right = unsafe { base.add(lefts * steps * g.width) };
                let sums = unsafe { right.add(panels * steps * g.width) };
                let reps = 8_000_000_000 / (steps * g.rows * g.width * panels * lefts * g.width / g.rows) + 1;
                let t = std::time::Instant::now();
                for _ in 0..reps {
                    for i in 0..lefts * g.width / g.rows {
                        for j in 0..panels {
                            unsafe {
                                k.multiply(steps, base.add(i * g.rows / g.width * steps * g.width + i * g.rows % g.width), right.add(j * steps * g.width), g.width / g.lanes, sums.add((i * panels + j) * g.rows * g.width), true, &[]);
                            }
                        }
                    }
                }
                let e = t.elapsed().as_secs_f64();
                println!("{} steps {steps} panels {panels} lefts {lefts}: {:.1} GF", T::NAME, 2.0 * (reps * steps * g.rows * g.width * panels * lefts * g.width / g.rows) as f64 / e / 1e9);
            }
        }
    }
    one::<f64>();

}
