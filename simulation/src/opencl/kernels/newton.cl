// Newton's fractals (thesis, chapter 7): the same operations in the same order as
// simulation/src/texture/newton/iterate.rs; change both.
//
// A work-item computes LANES points at a time: the width of a register on processors, 1 on graphics
// cards.

#pragma OPENCL FP_CONTRACT OFF

#define JOIN2(a, b) a##b
#define JOIN(a, b) JOIN2(a, b)

#if LANES == 1
typedef float real;
typedef int mask;
typedef uint bits;
typedef ushort small;
#define LOAD(i, p) (p)[i]
#define STORE(x, i, p) (p)[i] = (x)
#define AS_BITS(x) as_uint(x)
#define AS_REAL(x) as_float(x)
#define TO_SMALL(x) convert_ushort(x)
#define TO_REAL(x) convert_float(x)
#define SELECT(mask, yes, no) ((mask) ? (yes) : (no))
#define ANY(mask) (mask)
#define NONE 0
#define ALL 1
#else
typedef JOIN(float, LANES) real;
typedef JOIN(int, LANES) mask;
typedef JOIN(uint, LANES) bits;
typedef JOIN(ushort, LANES) small;
#define LOAD(i, p) JOIN(vload, LANES)(i, p)
#define STORE(x, i, p) JOIN(vstore, LANES)(x, i, p)
#define AS_BITS(x) JOIN(as_uint, LANES)(x)
#define AS_REAL(x) JOIN(as_float, LANES)(x)
#define TO_SMALL(x) JOIN(convert_ushort, LANES)(x)
#define TO_REAL(x) JOIN(convert_float, LANES)(x)
#define SELECT(mask, yes, no) select(no, yes, mask)
#define ANY(mask) any(mask)
#define NONE (mask)(0)
#define ALL (mask)(-1)
#endif

#define ZERO 1e-30f
#define ENDLESS 1e30f
#define LONG 30.0f
#define TO_NEAREST 12582912.0f

typedef struct {
    real re, im;
} number;

inline number times(number a, number b) {
    return (number){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

inline real norm2_of(number z) { return z.re * z.re + z.im * z.im; }

inline number inverse(number z, real norm2) {
    real all_of = (real)(1.0f) / norm2;
    return (number){z.re * all_of, (real)(0.0f) - z.im * all_of};
}

inline number select_number(mask which, number yes, number no) {
    return (number){SELECT(which, yes.re, no.re), SELECT(which, yes.im, no.im)};
}

inline real step2_of(number from, number to) {
    number step = {to.re - from.re, to.im - from.im};
    return norm2_of(step);
}

inline number power(number z, uint n) {
    number result = z;
    for (int bit = 30 - (int)clz(n); bit >= 0; bit--) {
        result = times(result, result);
        if (n >> bit & 1u) {
            result = times(result, z);
        }
    }
    return result;
}

inline number step_of_power(number z, uint degree, float nearest, real *step2) {
    real norm2 = norm2_of(z);
    real n = (real)((float)degree);
    real ours = (real)((float)(degree - 1u)) / n, next = (real)(1.0f) / n;
    mask near = norm2 < nearest;
    mask zero = NONE;
    number base = z;
    real base2 = norm2;
    if (ANY(near)) {
        zero = norm2 < ZERO;
        real away = sqrt((real)(nearest) / fmax(norm2, (real)(ZERO)));
        number scaled = {z.re * away, z.im * away};
        base = select_number(near, scaled, z);
        base2 = SELECT(zero, (real)(1.0f), norm2_of(base));
    }
    number raised = power(inverse(base, base2), degree - 1u);
    number to = {z.re * ours + raised.re * next, z.im * ours + raised.im * next};
    to = select_number(zero, z, to);
    *step2 = SELECT(zero, (real)(ENDLESS), step2_of(z, to));
    return to;
}

inline number step_of_roots(number z, uint degree, __global const float2 *roots, real *step2) {
    number sum = {(real)(0.0f), (real)(0.0f)};
    real closest = (real)(FLT_MAX);
    for (uint k = 0; k < degree; k++) {
        number away = {z.re - roots[k].x, z.im - roots[k].y};
        real norm2 = norm2_of(away);
        closest = fmin(closest, norm2);
        number one = inverse(away, fmax(norm2, (real)(ZERO)));
        sum.re = sum.re + one.re;
        sum.im = sum.im + one.im;
    }
    real norm2 = norm2_of(sum);
    mask at_root = closest < ZERO, endless = norm2 < ZERO;
    number step = inverse(sum, fmax(norm2, (real)(ZERO)));
    number to = {z.re - step.re, z.im - step.im};
    to = select_number(at_root, z, select_number(endless, z, to));
    *step2 = SELECT(at_root, (real)(0.0f), SELECT(endless, (real)(ENDLESS), step2_of(z, to)));
    return to;
}

inline real exp_minus_one(real x) {
    real shifted = x * 1.44269504f + TO_NEAREST;
    real n = shifted - TO_NEAREST;
    real r = (x - n * 0.6933594f) - n * -2.1219444e-4f;
    real series = (real)(1.0f / 5040.0f);
    series = series * r + 1.0f / 720.0f;
    series = series * r + 1.0f / 120.0f;
    series = series * r + 1.0f / 24.0f;
    series = series * r + 1.0f / 6.0f;
    series = series * r + 1.0f / 2.0f;
    real low = (series * r) * r + r;
    real exponent = AS_REAL((AS_BITS(shifted) << 23u) + 0x3f800000u);
    return exponent * low + (exponent - 1.0f);
}

inline real turn(number z) {
    real x = fabs(z.re), y = fabs(z.im);
    real low = fmin(x, y), high = fmax(x, y);
    real q = low / fmax(high, (real)(1e-30f));
    real q2 = q * q;
    real series = (real)(0.0028662257f);
    series = series * q2 + -0.016165737f;
    series = series * q2 + 0.042909614f;
    series = series * q2 + -0.07528964f;
    series = series * q2 + 0.10656264f;
    series = series * q2 + -0.142089f;
    series = series * q2 + 0.19993551f;
    series = series * q2 + -0.33333145f;
    series = series * q2 + 1.0f;
    real eighth = series * q * 0.159154943f;
    real quarter = SELECT(x < y, 0.25f - eighth, eighth);
    real half_turn = SELECT(z.re < 0.0f, 0.5f - quarter, quarter);
    return SELECT(z.im < 0.0f, (real)(0.0f) - half_turn, half_turn);
}

inline real root_of(number z, uint degree, __global const float2 *roots, int has_roots) {
    if (has_roots) {
        real best = (real)(0.0f), closest = (real)(FLT_MAX);
        for (uint k = 0; k < degree; k++) {
            number away = {z.re - roots[k].x, z.im - roots[k].y};
            real norm2 = norm2_of(away);
            mask closer = norm2 < closest;
            best = SELECT(closer, (real)((float)k), best);
            closest = SELECT(closer, norm2, closest);
        }
        return best;
    }
    real n = (real)((float)degree);
    real k = (turn(z) * n + TO_NEAREST) - TO_NEAREST;
    return SELECT(k < 0.0f, k + n, k);
}

// The arguments that all points have in common; see Parameters in simulation/src/texture/newton/options.rs.
#define COMMON                                                                                     \
    __global const float2 *roots, int has_roots, uint degree, uint steps, int squared, float gain,  \
        float factor, float shift, float scale, float4 offset, float nearest, float arrived
#define COMMON_NAMES                                                                               \
    roots, has_roots, degree, steps, squared, gain, factor, shift, scale, offset, nearest, arrived

inline void iterate(real x, real y, real z, size_t at, __global ushort *numbers,
                    __global float *convergence, COMMON) {
    x = (x + offset.x) * scale;
    y = (y + offset.y) * scale;
    z = (z + offset.z) * scale;
    float w = offset.w * scale;
    number alpha = {x + w, y - z}, beta = {x - w, y + z};
    real sum = (real)(0.0f);
    mask active = ALL;
    for (uint step = 0; step < steps; step++) {
        real step_alpha, step_beta;
        number next_alpha, next_beta;
        if (has_roots) {
            next_alpha = step_of_roots(alpha, degree, roots, &step_alpha);
            next_beta = step_of_roots(beta, degree, roots, &step_beta);
        } else {
            next_alpha = step_of_power(alpha, degree, nearest, &step_alpha);
            next_beta = step_of_power(beta, degree, nearest, &step_beta);
        }
        real step2 = (step_alpha + step_beta) * 0.5f;
        real length_of = squared ? step2 : sqrt(step2);
        real excess = exp_minus_one(fmin(length_of, (real)(LONG))) * gain;
        sum = SELECT(active, sum + excess / (excess + 1.0f), sum);
        alpha = select_number(active, next_alpha, alpha);
        beta = select_number(active, next_beta, beta);
        active = active & (step2 >= arrived);
        if (!ANY(active)) {
            break;
        }
    }
    real root = root_of(alpha, degree, roots, has_roots) * (float)degree
              + root_of(beta, degree, roots, has_roots);
    // A mark for points that reach no root.
    root = root + SELECT(active, (real)(32768.0f), (real)(0.0f));
    STORE(TO_SMALL(root), at, numbers);
    STORE(sum * factor + shift, at, convergence);
}

// Computes points `first` and following of a grid; `items` work-items have points to compute.
__kernel void newton_grid(uint items, uint first, uint columns, uint rows, float4 origin, float4 right,
                          float4 down, float4 back, __global ushort *numbers,
                          __global float *convergence, COMMON) {
    size_t at = get_global_id(0);
    if (at >= items) {
        return;
    }
#if LANES == 1
    bits number_of = (uint)at + first;
#elif LANES == 4
    bits number_of = (uint)(at * LANES) + first + (bits)(0, 1, 2, 3);
#elif LANES == 8
    bits number_of = (uint)(at * LANES) + first + (bits)(0, 1, 2, 3, 4, 5, 6, 7);
#else
    bits number_of = (uint)(at * LANES) + first
                   + (bits)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#endif
    bits line = number_of / columns, plane = line / rows;
    real i = TO_REAL(number_of - line * columns), j = TO_REAL(line - plane * rows), k = TO_REAL(plane);
    real x = ((origin.x + k * back.x) + j * down.x) + i * right.x;
    real y = ((origin.y + k * back.y) + j * down.y) + i * right.y;
    real z = ((origin.z + k * back.z) + j * down.z) + i * right.z;
    iterate(x, y, z, at, numbers, convergence, COMMON_NAMES);
}

// Computes points of a list, whose coordinates are in separate arrays.
__kernel void newton_list(uint items, __global const float *xs, __global const float *ys,
                          __global const float *zs, __global ushort *numbers,
                          __global float *convergence, COMMON) {
    size_t at = get_global_id(0);
    if (at >= items) {
        return;
    }
    iterate(LOAD(at, xs), LOAD(at, ys), LOAD(at, zs), at, numbers, convergence, COMMON_NAMES);
}
