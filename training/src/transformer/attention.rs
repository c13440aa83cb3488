//! Attention of eight heads (Vaswani et al. 2017), without the linear maps around it.
//!
//! Head h has the channels h, h + 8, h + 16 and h + 24 of a token, so that one vector instruction
//! works on all heads. Which channels a head has does not matter, as the linear maps are learned.

use catamaran_geometry::unions::network::{K, Number};

use super::layout::{HEADS, WIDTH};

/// One number per head.
type Heads<T> = [T; HEADS];
/// The channels of a token.
type Token<T> = [Heads<T>; WIDTH / HEADS];

/// One over the square root of the number of channels of a head.
const SCALE: f64 = 0.5;
const _: () = assert!(SCALE * SCALE * (WIDTH / HEADS) as f64 == 1.0);

fn tokens<T>(x: &[T]) -> &[Token<T>] {
    x.as_chunks().0.as_chunks().0
}

fn tokens_mut<T>(x: &mut [T]) -> &mut [Token<T>] {
    x.as_chunks_mut().0.as_chunks_mut().0
}

/// Returns, for each head, the dot product of its channels.
#[inline]
fn dot<T: Number>(a: &Token<T>, b: &Token<T>) -> Heads<T> {
    let mut sums = [T::ZERO; HEADS];
    for (a, b) in a.iter().zip(b) {
        for h in 0..HEADS {
            sums[h] += a[h] * b[h];
        }
    }
    sums
}

/// Adds a token, times a factor per head.
#[inline]
fn add_scaled<T: Number>(sum: &mut Token<T>, factors: &Heads<T>, x: &Token<T>) {
    for (sum, x) in sum.iter_mut().zip(x) {
        for h in 0..HEADS {
            sum[h] += factors[h] * x[h];
        }
    }
}

/// Returns the first token to which token `i` of `count` attends: that of its own sequence, or of
/// the sequence `shift` further on, cyclically.
fn first(i: usize, shift: usize, count: usize) -> usize {
    (i / K + shift) * K % count
}

/// Computes the attention from queries, `WIDTH` per token, and keys and values, `2 WIDTH` per
/// token: `context` contains for each token the means of the values, weighted by `probabilities`,
/// `K x HEADS` per token.
pub fn attend<T: Number>(
    [query, source]: [&[T]; 2],
    shift: usize,
    probabilities: &mut [T],
    context: &mut [T],
) {
    let scale = T::from_f64(SCALE);
    let (query, source) = (tokens(query), tokens(source).as_chunks().0);
    let probabilities = probabilities.as_chunks_mut().0.chunks_exact_mut(K);
    let results = tokens_mut(context).iter_mut().zip(probabilities);
    for (i, (context, scores)) in results.enumerate() {
        let source = &source[first(i, shift, query.len())..][..K];
        let mut largest = [T::from_f64(f64::NEG_INFINITY); HEADS];
        for (scores, [key, _]) in scores.iter_mut().zip(source) {
            *scores = dot(&query[i], key).map(|x| scale * x);
            for h in 0..HEADS {
                largest[h] = if scores[h] > largest[h] { scores[h] } else { largest[h] };
            }
        }
        let mut total = [T::ZERO; HEADS];
        for scores in scores.iter_mut() {
            for h in 0..HEADS {
                scores[h] = (scores[h] - largest[h]).exp();
                total[h] += scores[h];
            }
        }
        let inverse = total.map(|total| T::ONE / total);
        let mut sum = [[T::ZERO; HEADS]; WIDTH / HEADS];
        for (scores, [_, value]) in scores.iter_mut().zip(source) {
            for h in 0..HEADS {
                scores[h] *= inverse[h];
            }
            add_scaled(&mut sum, scores, value);
        }
        *context = sum;
    }
}

/// Adds the gradients with respect to queries, keys and values, given that with respect to the
/// context.
pub fn attend_back<T: Number>(
    [query, source, probabilities]: [&[T]; 3],
    shift: usize,
    by_context: &[T],
    by_query: &mut [T],
    by_source: &mut [T],
) {
    let scale = T::from_f64(SCALE);
    let (query, source) = (tokens(query), tokens(source).as_chunks().0);
    let by_source = tokens_mut(by_source).as_chunks_mut().0;
    let probabilities = probabilities.as_chunks().0.chunks_exact(K);
    let rows = tokens(by_context).iter().zip(probabilities).zip(tokens_mut(by_query));
    for (i, ((by_context, probabilities), by_query)) in rows.enumerate() {
        let start = first(i, shift, query.len());
        let (source, by_source) = (&source[start..][..K], &mut by_source[start..][..K]);
        let mut by_scores = [[T::ZERO; HEADS]; K];
        let mut along = [T::ZERO; HEADS];
        for (j, [_, value]) in source.iter().enumerate() {
            by_scores[j] = dot(by_context, value);
            for h in 0..HEADS {
                along[h] += probabilities[j][h] * by_scores[j][h];
            }
        }
        for (j, ([key, _], [by_key, by_value])) in source.iter().zip(by_source).enumerate() {
            for h in 0..HEADS {
                by_scores[j][h] = scale * probabilities[j][h] * (by_scores[j][h] - along[h]);
            }
            add_scaled(by_query, &by_scores[j], key);
            add_scaled(by_key, &by_scores[j], &query[i]);
            add_scaled(by_value, &probabilities[j], by_context);
        }
    }
}
