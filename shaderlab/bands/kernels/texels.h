/* Texels looked up by column, row and layer; the twin of sampling/reading.py. */

#ifndef SHADERLAB_TEXELS_H
#define SHADERLAB_TEXELS_H

typedef enum { REPEAT, MIRRORED_REPEAT, CLAMP_TO_EDGE, CLAMP_TO_BORDER, OTHERWISE } Wrap;

static Wrap wrap_of(PyObject *mode)
{
    static const char *const names[] = {
        "repeat", "mirrored_repeat", "clamp_to_edge", "clamp_to_border"};
    if (!PyUnicode_Check(mode)) return OTHERWISE;
    for (int k = 0; k < OTHERWISE; k++)
        if (PyUnicode_CompareWithASCIIString(mode, names[k]) == 0) return k;
    return OTHERWISE;
}

static inline int64_t modulo(int64_t index, int64_t size)
{
    int64_t rest = index % size;
    return rest < 0 ? rest + size : rest;
}

static inline int64_t folded(int64_t index, int64_t size)
{
    return index < size ? index : 2 * size - 1 - index;
}

/* The texels that whole numbers stand for, -1 for the border; nonzero where one is no number of a
 * sensible size. */
LOOP int64_t wrap(
    npy_intp count, const double *at, int64_t size, Wrap mode, int64_t *restrict to)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        int sensible = fabs(at[i]) < 0x1p52;
        rare |= sensible ? 0 : ODD;
        to[i] = (int64_t)(sensible ? at[i] : 0.0);
    }
    int64_t period = mode == MIRRORED_REPEAT ? 2 * size : size;
    if (mode == CLAMP_TO_EDGE)
        for (npy_intp i = 0; i < count; i++) {
            int64_t least = to[i] > 0 ? to[i] : 0;
            to[i] = least < size ? least : size - 1;
        }
    else if (mode == CLAMP_TO_BORDER)
        for (npy_intp i = 0; i < count; i++) to[i] = (to[i] < 0) | (to[i] >= size) ? -1 : to[i];
    else if (!(period & (period - 1)))
        for (npy_intp i = 0; i < count; i++) to[i] &= period - 1;
    else
        for (npy_intp i = 0; i < count; i++) to[i] = modulo(to[i], period);
    if (mode == MIRRORED_REPEAT)
        for (npy_intp i = 0; i < count; i++) to[i] = folded(to[i], size);
    return rare;
}

/* A number of 16 bits: five of the exponent, ten of the fraction. */
static inline double of_half(uint16_t bits)
{
    uint64_t moved = (uint64_t)(bits & 0x7FFF) << 42;
    double size, beyond = bits & 0x3FF ? NAN : INFINITY;
    memcpy(&size, &moved, sizeof size);
    size = (bits & 0x7C00) == 0x7C00 ? beyond : size * 0x1p1008;
    return bits >> 15 ? -size : size;
}

/* A level of a texture, how its numbers are read, and where. */
typedef struct {
    const void *data;
    int type;
    npy_intp layers, height, width, channels;
    Wrap across, up;
    const double *tables[2], *border;
    double error;
    const int64_t *layer;
    npy_intp count;
} Level;

/* Four components of each texel, of the border for -1: absent ones are 0, absent alpha 1. */
#define COPY_TEXELS(type, channels, read)                                           \
    for (npy_intp i = 0; i < count; i++) {                                          \
        const type *texel = (const type *)level->data + place[i] * channels;        \
        if (place[i] < 0) memcpy(to + 4 * i, level->border, 4 * sizeof *to);        \
        else                                                                        \
            for (npy_intp k = 0; k < 4; k++)                                        \
                to[4 * i + k] = k < channels ? (read) : k == 3 ? 1.0 : 0.0;         \
    }
#define COPY_ANY(type, read)                                                        \
    {                                                                               \
        if (level->channels == 4) COPY_TEXELS(type, 4, read)                        \
        else if (level->channels == 1) COPY_TEXELS(type, 1, read)                   \
        else COPY_TEXELS(type, level->channels, read)                               \
    }

LOOP void copy_texels(
    const Level *level, npy_intp count, const double *table, const int64_t *place,
    double *restrict to)
{
    if (level->type == NPY_UBYTE) COPY_ANY(uint8_t, table[texel[k]])
    else if (level->type == NPY_HALF) COPY_ANY(uint16_t, of_half(texel[k]))
    else if (level->type == NPY_FLOAT) COPY_ANY(float, (double)texel[k])
    else COPY_ANY(double, texel[k])
}

/* Numbers neither 0 nor 1 moved by a relative error. */
LOOP void err(npy_intp count, double error, double *restrict low, double *restrict high)
{
    for (npy_intp i = 0; i < count; i++) {
        double number = low[i];
        double give = (number == 0.0) | (number == 1.0) ? 0.0 : error * number;
        low[i] = number - give;
        high[i] = number + give;
    }
}

/* What is stored at some places, as bounds. */
static void read_texels(
    const Level *level, npy_intp count, const int64_t *place, double *restrict low,
    double *restrict high)
{
    const double *lowest = level->tables[0], *highest = level->tables[1];
    copy_texels(level, count, lowest, place, low);
    if (level->error != 0.0) {
        err(4 * count, level->error, low, high);
        for (npy_intp i = 0; i < count; i++)
            for (npy_intp k = 0; k < 4 && place[i] < 0; k++)
                low[4 * i + k] = high[4 * i + k] = level->border[k];
    } else if (lowest != highest) copy_texels(level, count, highest, place, high);
    else memcpy(high, low, 4 * count * sizeof *low);
}

/* The places of whole numbers across and up, in these layers; nonzero where there is none. */
LOOP int64_t places_at(
    const Level *level, const int64_t *layer, npy_intp count, const double *x, const double *y,
    int64_t *restrict place)
{
    int64_t row[BLOCK], rare = wrap(count, x, level->width, level->across, place);
    rare |= wrap(count, y, level->height, level->up, row);
    int64_t width = level->width, height = level->height, layers = level->layers;
    for (npy_intp i = 0; i < count; i++) {
        int64_t inside = (layer[i] * height + row[i]) * width + place[i];
        rare |= (layer[i] < -1) | (layer[i] >= layers) ? ODD : 0;
        place[i] = (layer[i] < 0) | (row[i] < 0) | (place[i] < 0) ? -1 : inside;
    }
    return rare;
}

/* An array of one axis of this length, or none. */
static const void *row_of(PyObject *object, int type, npy_intp *length)
{
    if (!PyArray_Check(object)) return NULL;
    PyArrayObject *array = (PyArrayObject *)object;
    if (PyArray_TYPE(array) != type || PyArray_NDIM(array) != 1) return NULL;
    if (!PyArray_ISCARRAY_RO(array)) return NULL;
    if (*length < 0) *length = PyArray_DIM(array, 0);
    return PyArray_DIM(array, 0) == *length ? PyArray_DATA(array) : NULL;
}

/* Reads (values, layer, wrap of x, wrap of y, lowest, highest, error, border); false where NumPy
 * must do it. */
static int read_level(Level *level, PyObject *const *args)
{
    npy_intp codes = 256, four = 4;
    if (!PyArray_Check(args[0])) return 0;
    PyArrayObject *values = (PyArrayObject *)args[0];
    int type = level->type = PyArray_TYPE(values), coded = type == NPY_UBYTE;
    if (PyArray_NDIM(values) != 4 || !PyArray_ISCARRAY_RO(values)) return 0;
    if (!coded && type != NPY_HALF && type != NPY_FLOAT && type != NPY_DOUBLE) return 0;
    level->count = -1;
    level->layer = row_of(args[1], NPY_INT64, &level->count);
    level->across = wrap_of(args[2]);
    level->up = wrap_of(args[3]);
    if (!level->layer || level->across == OTHERWISE || level->up == OTHERWISE) return 0;
    for (int k = 0; k < 2; k++) {
        level->tables[k] = coded ? row_of(args[4 + k], NPY_DOUBLE, &codes) : NULL;
        if (coded && !level->tables[k]) return 0;
    }
    level->error = PyFloat_Check(args[6]) ? PyFloat_AS_DOUBLE(args[6]) : 0.0;
    level->border = row_of(args[7], NPY_DOUBLE, &four);
    const npy_intp *dims = PyArray_DIMS(values);
    level->data = PyArray_DATA(values);
    level->layers = dims[0];
    level->height = dims[1];
    level->width = dims[2];
    level->channels = dims[3];
    return level->border && level->count && dims[1] && dims[2] && dims[3] <= 4;
}

/* Makes room for four components of each place. */
static int room_for_texels(Result *result, const Level *level)
{
    Shape shape = {.ndim = 2, .dims = {level->count, 4}, .size = 4 * level->count};
    result->exact = level->tables[0] == level->tables[1] && level->error == 0.0;
    return make_room(result, &shape, 0, 0);
}

static npy_intp texels_in(const Level *level, npy_intp start)
{
    return level->count - start < BLOCK ? level->count - start : BLOCK;
}

/* texels_at(x, y, values, layer, wrap of x, wrap of y, lowest, highest, error, border):
 * (low, high). */
static PyObject *texels_at(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Result result = {0};
    Level level;
    if (given != 10 || !read_level(&level, args + 2)) Py_RETURN_NONE;
    const double *x = row_of(args[0], NPY_DOUBLE, &level.count);
    const double *y = row_of(args[1], NPY_DOUBLE, &level.count);
    if (!x || !y) Py_RETURN_NONE;
    if (room_for_texels(&result, &level)) return NULL;
    for (npy_intp start = 0; start < level.count && !result.rare; start += BLOCK) {
        int64_t place[BLOCK];
        npy_intp some = texels_in(&level, start);
        result.rare = places_at(&level, level.layer + start, some, x + start, y + start, place);
        if (!result.rare)
            read_texels(&level, some, place, result.low + 4 * start, result.high + 4 * start);
    }
    return two_arrays(&result);
}

/* The whole numbers below both ends of coordinates; nonzero where those are too far apart. */
LOOP int64_t floors(
    npy_intp count, const double *lo, const double *hi, double *restrict first,
    double *restrict last)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        first[i] = floor(lo[i]);
        last[i] = floor(hi[i]);
        rare |= !(hi[i] - lo[i] <= 1.0) ? ODD : 0;
    }
    return rare;
}

/* Joins what some places hold with the other candidates there. */
static int64_t join_candidates(
    const Level *level, npy_intp count, const npy_intp *at, const int64_t *place,
    double *restrict low, double *restrict high)
{
    double one[4 * BLOCK], other[4 * BLOCK];
    int64_t rare = 0;
    read_texels(level, count, place, one, other);
    for (npy_intp i = 0; i < 4 * count; i++) {
        double *to_low = low + 4 * at[i / 4] + i % 4, *to_high = high + 4 * at[i / 4] + i % 4;
        rare |= (*to_low != *to_low) | (one[i] != one[i]) ? ODD : 0;
        *to_low = smaller(*to_low, one[i]);
        *to_high = larger(*to_high, other[i]);
    }
    return rare;
}

/* nearest_texels(lowest x, highest x, of y, then as texels_at): (low, high). */
static PyObject *nearest_texels(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Result result = {0};
    Level level;
    const double *ends[4];
    if (given != 12 || !read_level(&level, args + 4)) Py_RETURN_NONE;
    Operand operands[4];
    Shape shape;
    if (!read_operands(operands, args, 4, &shape)) Py_RETURN_NONE;
    if (shape.ndim != 1 || shape.size != level.count) Py_RETURN_NONE;
    if (room_for_texels(&result, &level)) return NULL;
    for (npy_intp start = 0; start < level.count && !result.rare; start += BLOCK) {
        ALIGNED double whole[4][BLOCK], x[BLOCK], y[BLOCK];
        int64_t place[BLOCK], layer[BLOCK];
        npy_intp some = texels_in(&level, start), at[BLOCK], crossing = 0;
        double *low = result.low + 4 * start, *high = result.high + 4 * start;
        for (int k = 0; k < 4; k++) ends[k] = values_at(&operands[k], start, some);
        for (int k = 0; k < 4; k += 2)
            result.rare |= floors(some, ends[k], ends[k + 1], whole[k], whole[k + 1]);
        result.rare |= places_at(&level, level.layer + start, some, whole[0], whole[2], place);
        if (result.rare) break;
        read_texels(&level, some, place, low, high);
        for (npy_intp i = 0; i < some; i++)
            if ((whole[0][i] != whole[1][i]) | (whole[2][i] != whole[3][i])) at[crossing++] = i;
        for (npy_intp i = 0; i < crossing; i++) layer[i] = level.layer[start + at[i]];
        for (int k = 1; k < 4 && crossing; k++) {
            for (npy_intp i = 0; i < crossing; i++) {
                x[i] = whole[k & 1][at[i]];
                y[i] = whole[2 + k / 2][at[i]];
            }
            result.rare |= places_at(&level, layer, crossing, x, y, place);
            result.rare |= join_candidates(&level, crossing, at, place, low, high);
        }
        result.differ |= crossing;
    }
    return two_arrays(&result);
}

#endif
