use catamaran::unions::network::{Architecture, K, Number};
use pulp::{Simd, WithSimd};

/// The gradient with respect to queries, keys and values, from that with respect to what attention mixed.
pub(super) struct AttentionBackward<'a, T> {
    pub sizes: &'a Architecture,
    pub queries_keys_values: &'a [T],
    pub attention: &'a [T],
    /// With respect to the mixed values.
    pub mixed: &'a [T],
    /// Written.
    pub gradient: &'a mut [T],
}

impl<T: Number> WithSimd for AttentionBackward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Architecture { width, heads, .. } = *self.sizes;
        let depth = width / heads;
        let scale = T::ONE / T::from_f64(depth as f64).sqrt();
        let line = 3 * width;
        let sequences = self.mixed.len() / (K * width);
        for sequence in 0..sequences {
            let given = &self.queries_keys_values[sequence * K * line..][..K * line];
            let gradient = &mut self.gradient[sequence * K * line..][..K * line];
            let mixed = &self.mixed[sequence * K * width..][..K * width];
            for head in 0..heads {
                let start = (sequence * heads + head) * K * K;
                let (weights, _) = self.attention[start..start + K * K].as_chunks::<K>();
                // With respect to the weights, then to the scores: a row for each key, queries in lanes.
                let mut scores = [[T::ZERO; K]; K];
                for t in head * depth..(head + 1) * depth {
                    let lanes: [T; K] = std::array::from_fn(|query| mixed[query * width + t]);
                    for key in 0..K {
                        let value = given[key * line + 2 * width + t];
                        for query in 0..K {
                            scores[key][query] += value * lanes[query];
                        }
                        gradient[key * line + 2 * width + t] = dot(&weights[key], &lanes);
                    }
                }
                let mut means = [T::ZERO; K];
                for key in 0..K {
                    for query in 0..K {
                        means[query] += weights[key][query] * scores[key][query];
                    }
                }
                for key in 0..K {
                    for query in 0..K {
                        scores[key][query] =
                            weights[key][query] * (scores[key][query] - means[query]);
                    }
                }
                for t in head * depth..(head + 1) * depth {
                    let queries: [T; K] =
                        std::array::from_fn(|query| given[query * line + t] * scale);
                    let mut lanes = [T::ZERO; K];
                    for key in 0..K {
                        let factor = given[key * line + width + t] * scale;
                        for query in 0..K {
                            lanes[query] += factor * scores[key][query];
                        }
                        gradient[key * line + width + t] = dot(&scores[key], &queries);
                    }
                    for query in 0..K {
                        gradient[query * line + t] = lanes[query];
                    }
                }
            }
        }
    }
}

/// The inner product, by four partial sums.
#[inline(always)]
fn dot<T: Number>(a: &[T; K], b: &[T; K]) -> T {
    let mut parts = [T::ZERO; 4];
    for i in (0..K).step_by(4) {
        for lane in 0..4 {
            parts[lane] += a[i + lane] * b[i + lane];
        }
    }
    (parts[0] + parts[2]) + (parts[1] + parts[3])
}
