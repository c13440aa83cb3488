// Slime moulds (thesis, chapter 3): the same operations in the same order as
// simulation/src/texture/slime/{agents,walk,random,diffuse}.rs; change both. simulation/src/texture/slime/mod.rs
// describes the contents of the buffers.

#pragma OPENCL FP_CONTRACT OFF

#define NO_TRIANGLE 0xffffffffu
#define ACROSS_FLIP 4u
#define HOPS 9
#define UV 21
#define RECORD 28
#define FRAME 12
#define TURNS 64u
#define CORNER 1e-6f
#define OUTSIDE 0
#define OBSTACLE 1
#define GOAL 2

// PoCL does not inline large functions: without this, walkers would go through memory at each call,
// which takes a third of the time.
#define INLINE inline __attribute__((always_inline))

typedef struct {
    uint triangle;
    float x, y, dx, dy;
} walker;

typedef struct {
    __global const float *records;
    __global const uint *across;
    __global const float *frames;
    int rescale;
} surface;

INLINE float stretch(const surface *s, const walker *w) {
    __global const float *r = s->records + (size_t)RECORD * w->triangle;
    float u = r[UV + 1] * w->dx + r[UV + 2] * w->dy;
    float v = r[UV + 4] * w->dx + r[UV + 5] * w->dy;
    return sqrt(u * u + v * v);
}

// Returns the edge by which a walker leaves its triangle within `reach`, 3 for none; `way` gets the
// distance to it in the triangle.
INLINE int first_exit(const surface *s, const walker *w, float reach, int entered, float *way) {
    __global const float *r = s->records + (size_t)RECORD * w->triangle;
    int exit_edge = 3;
    *way = reach;
    for (int k = 0; k < 3; k++) {
        float a = r[3 * k], b = r[3 * k + 1], c = r[3 * k + 2];
        float inside = a * w->x + b * w->y + c;
        float rate = a * w->dx + b * w->dy;
        if (k != entered && rate < 0.0f && inside + rate * reach < 0.0f) {
            float at = (inside > 0.0f ? inside : 0.0f) / -rate;
            if (at < *way) {
                exit_edge = k;
                *way = at;
            }
        }
    }
    return exit_edge;
}

// Moves a walker across edge k; returns the index of the edge in the new triangle.
INLINE int cross_edge(const surface *s, walker *w, int k) {
    __global const float *r = s->records + (size_t)RECORD * w->triangle;
    uint across = s->across[(size_t)3 * w->triangle + k];
    float dx = w->dx, dy = w->dy;
    if (across == NO_TRIANGLE) {
        float a = r[3 * k], b = r[3 * k + 1];
        float twice = 2.0f * (a * dx + b * dy);
        w->dx = dx - twice * a;
        w->dy = dy - twice * b;
        return k;
    }
    __global const float *hop = r + HOPS + 4 * k;
    float p = hop[0], q = hop[1];
    int flips = (across & ACROSS_FLIP) != 0u;
    float rr = flips ? -p : p, ss = flips ? q : -q;
    float x = w->x, y = w->y;
    w->triangle = across >> 3;
    w->x = p * x + ss * y + hop[2];
    w->y = q * x + rr * y + hop[3];
    w->dx = p * dx + ss * dy;
    w->dy = q * dx + rr * dy;
    return (int)(across & 3u);
}

INLINE walker unfold(const surface *s, walker w, float length_left) {
    int entered = 3;
    for (int hops = 0; hops < MOST_HOPS; hops++) {
        float stretched = s->rescale ? 1.0f : stretch(s, &w);
        float reach = s->rescale ? length_left : length_left / stretched;
        float way;
        int edge = first_exit(s, &w, reach, entered, &way);
        w.x = w.x + way * w.dx;
        w.y = w.y + way * w.dy;
        if (edge == 3) {
            break;
        }
        length_left -= way * stretched;
        entered = cross_edge(s, &w, edge);
    }
    return w;
}

INLINE void move_inside(const surface *s, walker *w) {
    __global const float *r = s->records + (size_t)RECORD * w->triangle;
    float least = fmin(fmin(r[0] * w->x + r[1] * w->y + r[2], r[3] * w->x + r[4] * w->y + r[5]),
                       r[6] * w->x + r[7] * w->y + r[8]);
    if (least >= 0.0f) {
        return;
    }
    for (int i = 0; i < 6; i++) {
        int k = i % 3;
        float a = r[3 * k], b = r[3 * k + 1], c = r[3 * k + 2];
        float inside = a * w->x + b * w->y + c;
        if (inside < 0.0f) {
            w->x = w->x - inside * a;
            w->y = w->y - inside * b;
        }
    }
    float p = r[6], q = r[7], l = r[8];
    for (int k = 0; k < 2; k++) {
        float a = r[3 * k], b = r[3 * k + 1], c = r[3 * k + 2];
        if (a * w->x + b * w->y + c < -CORNER) {
            float determinant = a * q - p * b;
            w->x = (b * l - q * c) / determinant;
            w->y = (p * c - a * l) / determinant;
        }
    }
}

INLINE float along(const float *a, __global const float *axis) {
    return a[0] * axis[0] + a[1] * axis[1] + a[2] * axis[2];
}

INLINE void project_across(const surface *s, walker *w, float ahead_x, float ahead_y, int edge) {
    uint t = w->triangle;
    __global const float *from = s->frames + (size_t)FRAME * t;
    __global const uint *across = s->across + (size_t)3 * t;
    __global const float *r = s->records + (size_t)RECORD * t;
    float point[3], direction[3], relative[3];
    for (int i = 0; i < 3; i++) {
        point[i] = from[i] + (ahead_x * from[3 + i] + ahead_y * from[6 + i]);
        direction[i] = w->dx * from[3 + i] + w->dy * from[6 + i];
    }
    int nearest = edge;
    float distance_of = 0.0f;
    for (int i = 0; i < 4; i++) {
        // The edge itself first, then the others in their order.
        int k = i == 0 ? edge : i - 1;
        if (i > 0) {
            float inside = r[3 * k] * ahead_x + r[3 * k + 1] * ahead_y + r[3 * k + 2];
            if (k == edge || !(inside < 0.0f) || across[k] == NO_TRIANGLE) {
                continue;
            }
        }
        __global const float *frame = s->frames + (size_t)FRAME * (across[k] >> 3);
        for (int c = 0; c < 3; c++) {
            relative[c] = point[c] - frame[c];
        }
        float other = fabs(along(relative, frame + 9));
        if (i == 0 || other < distance_of) {
            nearest = k;
            distance_of = other;
        }
    }
    __global const float *frame = s->frames + (size_t)FRAME * (across[nearest] >> 3);
    for (int c = 0; c < 3; c++) {
        relative[c] = point[c] - frame[c];
    }
    float hx = along(direction, frame + 3), hy = along(direction, frame + 6);
    float length_of = sqrt(hx * hx + hy * hy);
    cross_edge(s, w, nearest);
    if (length_of > 1e-3f) {
        w->dx = hx / length_of;
        w->dy = hy / length_of;
    }
    w->x = along(relative, frame + 3);
    w->y = along(relative, frame + 6);
}

// Returns how many of `most` sub-steps certainly stay in the triangle.
INLINE uint steps_inside(const surface *s, const walker *w, float length_of, uint most) {
    __global const float *r = s->records + (size_t)RECORD * w->triangle;
    float steps = (float)min(most, 1u << 24);
    float way = length_of * steps;
    float roundings = FLT_EPSILON * (steps + 16.0f);
    for (int k = 0; k < 3; k++) {
        float a = r[3 * k], b = r[3 * k + 1], c = r[3 * k + 2];
        float inside = a * w->x + b * w->y + c;
        float rate = a * w->dx + b * w->dy;
        float margin = roundings * (fabs(w->x) + fabs(w->y) + fabs(c) + way);
        if (rate < 0.0f) {
            float here = (inside - margin) / -(rate * length_of);
            steps = here < steps ? here : steps;
        }
    }
    return (uint)(steps > 0.0f ? steps : 0.0f);
}

INLINE void substep(const surface *s, walker *w, float reach) {
    float way;
    int edge = first_exit(s, w, reach, 3, &way);
    float ahead_x = w->x + reach * w->dx, ahead_y = w->y + reach * w->dy;
    if (edge == 3) {
        w->x = ahead_x;
        w->y = ahead_y;
        return;
    }
    if (s->across[(size_t)3 * w->triangle + edge] == NO_TRIANGLE) {
        __global const float *r = s->records + (size_t)RECORD * w->triangle;
        float a = r[3 * edge], b = r[3 * edge + 1], c = r[3 * edge + 2];
        float twice = 2.0f * (a * ahead_x + b * ahead_y + c);
        cross_edge(s, w, edge);
        w->x = ahead_x - twice * a;
        w->y = ahead_y - twice * b;
    } else {
        project_across(s, w, ahead_x, ahead_y, edge);
    }
    move_inside(s, w);
}

INLINE walker project(const surface *s, walker w, float step_length, uint count) {
    uint left = count;
    while (left > 0u) {
        float reach = s->rescale ? step_length : step_length / stretch(s, &w);
        uint inside = steps_inside(s, &w, reach, left);
        float dx = reach * w.dx, dy = reach * w.dy;
        for (uint i = 0; i < inside; i++) {
            w.x = w.x + dx;
            w.y = w.y + dy;
        }
        left -= inside;
        if (left > 0u) {
            substep(s, &w, reach);
            left--;
        }
    }
    return w;
}

INLINE walker walk(const surface *s, walker w, float length_of, uint substeps) {
    return substeps == 0u ? unfold(s, w, length_of) : project(s, w, length_of, substeps);
}

INLINE uint texel_of(const surface *s, uint size, const walker *w) {
    __global const float *r = s->records + (size_t)RECORD * w->triangle;
    float u = r[UV] + r[UV + 1] * w->x + r[UV + 2] * w->y;
    float v = r[UV + 3] + r[UV + 4] * w->x + r[UV + 5] * w->y;
    uint column = min(convert_uint_sat(u * (float)size), size - 1u);
    uint row = min(convert_uint_sat(v * (float)size), size - 1u);
    return row * size + column;
}

INLINE walker rotated(walker w, float dx, float dy, float cosine, float sine) {
    w.dx = cosine * dx - sine * dy;
    w.dy = sine * dx + cosine * dy;
    return w;
}

// Returns the texel of the sensor of a walker.
INLINE uint sensed(const surface *s, walker w, float sense, uint substeps, uint size) {
    walker end = walk(s, w, sense, substeps);
    return texel_of(s, size, &end);
}

INLINE void mix_bits(uint *v) {
    v[0] += v[1] * v[3];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
    v[3] += v[1] * v[2];
}

INLINE float smell(__global const float *texture, __global const uchar *ground, int has_ground,
                   float attraction, uint plane, uint species_count, uint species, uint texel) {
    float sum = texture[(size_t)species * plane + texel];
    for (uint other = 0; other < species_count; other++) {
        if (other != species) {
            sum -= texture[(size_t)other * plane + texel];
        }
    }
    if (has_ground) {
        uchar here = ground[texel];
        if (here == OBSTACLE) {
            return -INFINITY;
        }
        if (here == GOAL) {
            return sum + attraction;
        }
    }
    return sum;
}

// Computes a step of each agent, and marks the texel where it ends.
__kernel void slime_agents(uint count, uint step, uint seed, uint size, uint species_count, uint substeps,
                           int rescale, float sense, float advance, float2 vision,
                           __global const float2 *turns, float attraction,
                           __global const float *records, __global const uint *across,
                           __global const float *frames, __global const float *texture,
                           __global const uchar *ground, int has_ground, __global const uint *ids,
                           __global uint *triangles, __global float2 *positions,
                           __global float2 *headings, volatile __global uint *marks) {
    size_t i = get_global_id(0);
    if (i >= count) {
        return;
    }
    surface s = {records, across, frames, rescale};
    uint agent = ids[i];
    float2 position = positions[i], heading = headings[i];
    walker here = {triangles[i], position.x, position.y, heading.x, heading.y};
    uint species = agent % species_count, plane = size * size;

    uint t_ahead = sensed(&s, here, sense, substeps, size);
    walker turned = rotated(here, here.dx, here.dy, vision.x, vision.y);
    uint t_left = sensed(&s, turned, sense, substeps, size);
    turned = rotated(here, here.dx, here.dy, vision.x, -vision.y);
    uint t_right = sensed(&s, turned, sense, substeps, size);
    // All three at once, so that their memory accesses overlap.
    float ahead =
        smell(texture, ground, has_ground, attraction, plane, species_count, species, t_ahead);
    float left =
        smell(texture, ground, has_ground, attraction, plane, species_count, species, t_left);
    float right =
        smell(texture, ground, has_ground, attraction, plane, species_count, species, t_right);

    // PCG4D of (agent, step, purpose 0, seed).
    uint v[4] = {agent, step, 0u, seed};
    for (int c = 0; c < 4; c++) {
        v[c] = v[c] * 1664525u + 1013904223u;
    }
    mix_bits(v);
    for (int c = 0; c < 4; c++) {
        v[c] ^= v[c] >> 16;
    }
    mix_bits(v);
    float2 turn = turns[v[0] % TURNS];
    uint coin = v[1];

    walker next = here;
    if (ahead < left || ahead < right) {
        int to_left = left == right ? (coin & 1u) == 0u : left > right;
        next = rotated(next, here.dx, here.dy, turn.x, to_left ? turn.y : -turn.y);
    }
    next = walk(&s, next, advance, substeps);
    uint reached = texel_of(&s, size, &next);
    if (has_ground) {
        uint before = texel_of(&s, size, &here);
        uchar from = ground[before], to = ground[reached];
        if ((to == OBSTACLE && from != OBSTACLE) || (from == GOAL && to != GOAL)) {
            float sine = (coin & 2u) == 0u ? turn.y : -turn.y;
            next = rotated(here, -here.dx, -here.dy, turn.x, sine);
            reached = before;
        }
    }
    float factor = 1.5f - 0.5f * (next.dx * next.dx + next.dy * next.dy);
    triangles[i] = next.triangle;
    positions[i] = (float2)(next.x, next.y);
    headings[i] = (float2)(next.dx * factor, next.dy * factor);
    uint entry = species * plane + reached;
    uint bit = 1u << (entry & 31u);
    // Most texels are marked already, and reading is cheaper than an atomic write.
    if ((marks[entry >> 5] & bit) == 0u) {
        atomic_or(&marks[entry >> 5], bit);
    }
}

// Returns the tile of TILE x TILE texels of an agent.
INLINE uint tile_of(__global const float *records, uint size, uint triangle, float2 position) {
    surface s = {records, 0, 0, 1};
    walker w = {triangle, position.x, position.y, 0.0f, 0.0f};
    uint texel = texel_of(&s, size, &w);
    return texel / size / TILE * (size / TILE) + texel % size / TILE;
}

// Counts the agents in each tile.
__kernel void slime_count(uint count, uint size, __global const float *records,
                          __global const uint *triangles, __global const float2 *positions,
                          volatile __global uint *tiles) {
    size_t i = get_global_id(0);
    if (i < count) {
        atomic_inc(&tiles[tile_of(records, size, triangles[i], positions[i])]);
    }
}

// Sums the counts of tiles: each work-item those of a run of tiles.
__kernel void slime_sums(uint tiles, uint run, __global const uint *counts, __global uint *sums) {
    uint i = (uint)get_global_id(0), first = i * run;
    if (first >= tiles) {
        return;
    }
    uint last = min(first + run, tiles), sum = 0u;
    for (uint tile = first; tile < last; tile++) {
        sum += counts[tile];
    }
    sums[i] = sum;
}

// Replaces the sums of runs by what is before each; one work-item does it.
__kernel void slime_before(uint runs, __global uint *sums) {
    if (get_global_id(0) > 0u) {
        return;
    }
    uint before = 0u;
    for (uint i = 0; i < runs; i++) {
        uint sum = sums[i];
        sums[i] = before;
        before += sum;
    }
}

// Writes the first position of each tile, and clears the counts for the next ordering: each
// work-item does a run of tiles.
__kernel void slime_firsts(uint tiles, uint run, __global uint *counts, __global const uint *sums,
                           __global uint *firsts) {
    uint i = (uint)get_global_id(0), first = i * run;
    if (first >= tiles) {
        return;
    }
    uint last = min(first + run, tiles), position = sums[i];
    for (uint tile = first; tile < last; tile++) {
        firsts[tile] = position;
        position += counts[tile];
        counts[tile] = 0u;
    }
}

// Moves each agent to the next position of its tile; `tiles` holds the first positions.
__kernel void slime_place(uint count, uint size, __global const float *records,
                          __global const uint *ids, __global const uint *triangles,
                          __global const float2 *positions, __global const float2 *headings,
                          volatile __global uint *tiles, __global uint *new_ids,
                          __global uint *new_triangles, __global float2 *new_positions,
                          __global float2 *new_headings) {
    size_t i = get_global_id(0);
    if (i >= count) {
        return;
    }
    uint triangle = triangles[i];
    float2 position = positions[i];
    uint to = atomic_inc(&tiles[tile_of(records, size, triangle, position)]);
    new_ids[to] = ids[i];
    new_triangles[to] = triangle;
    new_positions[to] = position;
    new_headings[to] = headings[i];
}

// Writes 1 where a texel is marked, and clears the marks; each work-item takes a word of marks.
__kernel void slime_deposit(uint words, __global uint *marks, __global float *texture) {
    size_t i = get_global_id(0);
    if (i >= words) {
        return;
    }
    uint word = marks[i];
    if (word != 0u) {
        for (uint bit = 0; bit < 32u; bit++) {
            if (word >> bit & 1u) {
                texture[32 * i + bit] = 1.0f;
            }
        }
        marks[i] = 0u;
    }
}

#define JOIN2(a, b) a##b
#define JOIN(a, b) JOIN2(a, b)
#if LANES == 1
typedef float real;
#define LOAD(p) (*(p))
#define STORE(x, p) *(p) = (x)
#define CLEAR(x, kinds) (*(kinds) == OUTSIDE ? 0.0f : (x))
#else
typedef JOIN(float, LANES) real;
#define LOAD(p) JOIN(vload, LANES)(0, p)
#define STORE(x, p) JOIN(vstore, LANES)(x, 0, p)
#define CLEAR(x, kinds)                                                                            \
    select(x, (real)(0.0f), JOIN(convert_int, LANES)(JOIN(vload, LANES)(0, kinds)) == OUTSIDE)
#endif

// Returns (1 2 1) along a row for LANES texels from `first` on; the texels at the ends are repeated
// beyond them.
INLINE real sum_along(__global const float *row, uint first, uint size) {
    real middle = LOAD(row + first);
    real before, after;
    if (first > 0u && first + LANES < size) {
        before = LOAD(row + first - 1u);
        after = LOAD(row + first + 1u);
    } else {
        float edges[LANES + 2];
        for (int k = 0; k < LANES + 2; k++) {
            edges[k] = row[min((uint)max((int)first + k - 1, 0), size - 1u)];
        }
        before = LOAD(edges);
        after = LOAD(edges + 2);
    }
    return (before + after) + 2.0f * middle;
}

// Blurs and evaporates; `lines` is the number of rows of all species.
__kernel void slime_diffuse(uint size, uint lines, float blend, float evaporation, int seam_aware,
                            __global const uchar *kinds, __global const float *texture,
                            __global float *next) {
    size_t i = get_global_id(0);
    uint pieces = size / LANES;
    uint line = (uint)(i / pieces), first = (uint)(i - (size_t)line * pieces) * LANES;
    if (line >= lines) {
        return;
    }
    uint row = line % size;
    __global const float *plane = texture + (size_t)(line - row) * size;
    __global const float *here = plane + (size_t)row * size;
    real up = sum_along(plane + (size_t)(row > 0u ? row - 1u : 0u) * size, first, size);
    real down = sum_along(plane + (size_t)min(row + 1u, size - 1u) * size, first, size);
    real middle = sum_along(here, first, size);
    real blurred = ((up + down) + 2.0f * middle) * 0.0625f;
    real p = LOAD(here + first);
    real result = fmax((p + blend * (blurred - p)) - evaporation, (real)(0.0f));
    if (seam_aware) {
        result = CLEAR(result, kinds + (size_t)row * size + first);
    }
    STORE(result, next + (size_t)line * size + first);
}

// Computes the texels at seams, which exchange pheromone with the texels to which they are linked.
__kernel void slime_border(uint count, uint plane, uint species_count, float blend, float evaporation,
                           __global const uint *border, __global const uint *starts,
                           __global const uint *links, __global const float *weights,
                           __global const float *texture, __global float *next) {
    size_t i = get_global_id(0);
    if (i >= (size_t)count * species_count) {
        return;
    }
    uint number = (uint)(i % count);
    size_t offset = (i / count) * plane;
    __global const float *from = texture + offset;
    float p = from[border[number]];
    float flow = 0.0f;
    for (uint link = starts[number]; link < starts[number + 1u]; link++) {
        flow += weights[link] * (from[links[link]] - p);
    }
    next[offset + border[number]] = fmax((p + blend * flow) - evaporation, 0.0f);
}

// Sums coverage and presence of species by columns or rows of `size` texels: work-item i sums the
// texels at `across` i and following, `along` apart, into entry `slot` + i.
__kernel void slime_cover(uint size, uint species_count, uint across, uint along, uint slot,
                          __global const float *areas, __global const float *texture,
                          __global ulong2 *sums) {
    size_t i = get_global_id(0);
    if (i >= (size_t)size * species_count) {
        return;
    }
    size_t first = i % size * across;
    __global const float *plane = texture + i / size * size * size;
    ulong2 sum = 0;
    for (uint k = 0; k < size; k++) {
        size_t texel = first + (size_t)k * along;
        float pheromone = plane[texel];
        ulong area = convert_ulong(areas[texel] * AREA_UNIT);
        sum.x += area * convert_ulong(pheromone * PHEROMONE_UNIT + 0.5f);
        sum.y += pheromone > 0.0f ? area : 0;
    }
    sums[slot + i] = sum;
}

// Writes the pheromone of `count` texels of a species, which begins at `first`, as bytes.
__kernel void slime_bytes(uint count, uint first, __global const float *texture,
                          __global uchar *bytes) {
    size_t i = get_global_id(0);
    if (i < count) {
        bytes[i] = convert_uchar_sat(round(255.0f * texture[first + i]));
    }
}
