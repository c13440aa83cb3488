// Newton's fractal of z^n - 1 with powers in polar form, as the thesis describes it: for comparison only.

inline float2 power(float2 z, int n) {
    float radius = pow(dot(z, z), 0.5f * n), angle = n * atan2(z.y, z.x);
    return radius * (float2)(cos(angle), sin(angle));
}

inline float2 step_of(float2 z, int n) { return ((n - 1) * z + power(z, 1 - n)) / n; }

inline uint root_of(float2 z, int n) {
    int k = (int)round(atan2(z.y, z.x) * n / 6.28318531f);
    return (uint)((k % n + n) % n);
}

__kernel void polar(float first_x, float first_y, float pixel, int n, int steps, float gain, int stops,
                    __global ushort *roots, __global float *convergence) {
    float x = first_x + get_global_id(0) * pixel, y = first_y - get_global_id(1) * pixel;
    float2 alpha = (float2)(x, y), beta = alpha;
    float sum = 0;
    for (int k = 0; k < steps; k++) {
        float2 a = step_of(alpha, n), b = step_of(beta, n);
        float delta2 = 0.5f * (dot(a - alpha, a - alpha) + dot(b - beta, b - beta));
        sum += 1 / (1 + gain * (exp(sqrt(delta2)) - 1));
        alpha = a, beta = b;
        if (stops && delta2 < 1e-10f) {
            sum += steps - 1 - k;
            break;
        }
    }
    size_t at = get_global_id(1) * get_global_size(0) + get_global_id(0);
    roots[at] = (ushort)(root_of(alpha, n) * n + root_of(beta, n));
    convergence[at] = steps - 1 - sum;
}
