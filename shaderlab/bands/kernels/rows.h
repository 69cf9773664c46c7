/* Vectors and matrices, one for each row or one for all of them, taken apart into their elements. */

#ifndef SHADERLAB_ROWS_H
#define SHADERLAB_ROWS_H

#define MAX_TERMS 4
/* Rows of a block: of two vectors and their products all elements fit into a first-level cache. */
#define ROWS 192

/* Where an array's elements lie: steps from row to row, line to line, and along a line. */
typedef struct {
    const double *data;
    npy_intp down, line, along;
} Place;

typedef struct {
    Value value;
    npy_intp rows, lines, terms;
    Place lo, hi, mag, slack, reach;
} Rows;

/* Of the array's axes the last is along the lines; with `lines` the one before is theirs. */
static Place place_of(const Operand *operand, int lines)
{
    PyArrayObject *array = operand->array;
    int ndim = PyArray_NDIM(array), row = ndim - 2 - lines;
    const npy_intp *strides = PyArray_STRIDES(array), one = sizeof(double);
    Place place = {.data = PyArray_DATA(array), .along = strides[ndim - 1] / one};
    if (lines) place.line = strides[ndim - 2] / one;
    if (row >= 0 && PyArray_DIM(array, row) != 1) place.down = strides[row] / one;
    return place;
}

/* Finds the rows of a band that was read; false where there are none of so few terms. */
static int find_rows(Rows *rows, int lines)
{
    Value *value = &rows->value;
    PyArrayObject *lo = value->lo.array;
    int ndim = PyArray_NDIM(lo), row = ndim - 2 - lines;
    if (row < -1 || row > 0 || !of_one_shape(value)) return 0;
    rows->terms = PyArray_DIM(lo, ndim - 1);
    rows->lines = lines ? PyArray_DIM(lo, ndim - 2) : 1;
    rows->rows = row < 0 ? 1 : PyArray_DIM(lo, row);
    if (rows->terms < 2 || rows->terms > MAX_TERMS || !rows->rows) return 0;
    if (!rows->lines || rows->lines > MAX_TERMS) return 0;
    rows->lo = place_of(&value->lo, lines);
    if (!value->exact) rows->hi = place_of(&value->hi, lines);
    if (!value->plain) rows->mag = place_of(&value->mag, lines);
    if (value->slackened) rows->slack = place_of(&value->slack, lines);
    if (value->reaching) rows->reach = place_of(&value->reach, lines);
    return 1;
}

/* One element of each of `count` rows. */
static const double *picked(
    const Place *place, npy_intp line, npy_intp term, npy_intp start, npy_intp count, double *block)
{
    const double *from = place->data + start * place->down + line * place->line
        + term * place->along;
    if (place->down == 1) return from;
    if (place->down) every(count, from, place->down, block);
    else
        for (npy_intp i = 0; i < count; i++) block[i] = *from;
    return block;
}

/* Vectors of three or four that lie one after the other, taken apart and put together. */
LOOP void take_apart(npy_intp count, npy_intp width, const double *from, double (*restrict to)[ROWS])
{
    if (width == 3)
        for (npy_intp i = 0; i < count; i++) {
            to[0][i] = from[3 * i];
            to[1][i] = from[3 * i + 1];
            to[2][i] = from[3 * i + 2];
        }
    else
        for (npy_intp i = 0; i < count; i++) {
            to[0][i] = from[4 * i];
            to[1][i] = from[4 * i + 1];
            to[2][i] = from[4 * i + 2];
            to[3][i] = from[4 * i + 3];
        }
}

LOOP void put_together(
    npy_intp count, npy_intp width, const double *const *from, double *restrict to)
{
    if (width == 2) {
        const double *x = from[0], *y = from[1];
        for (npy_intp i = 0; i < count; i++) {
            to[2 * i] = x[i];
            to[2 * i + 1] = y[i];
        }
    } else if (width == 3) {
        const double *x = from[0], *y = from[1], *z = from[2];
        for (npy_intp i = 0; i < count; i++) {
            to[3 * i] = x[i];
            to[3 * i + 1] = y[i];
            to[3 * i + 2] = z[i];
        }
    } else if (width == 4) {
        const double *x = from[0], *y = from[1], *z = from[2], *w = from[3];
        for (npy_intp i = 0; i < count; i++) {
            to[4 * i] = x[i];
            to[4 * i + 1] = y[i];
            to[4 * i + 2] = z[i];
            to[4 * i + 3] = w[i];
        }
    } else
        for (npy_intp j = 0; j < width; j++)
            for (npy_intp i = 0; i < count; i++) to[i * width + j] = from[j][i];
}

static void put_blocks_together(
    npy_intp count, npy_intp width, double (*blocks)[ROWS], double *to)
{
    const double *from[MAX_TERMS];
    for (npy_intp j = 0; j < width; j++) from[j] = blocks[j];
    put_together(count, width, from, to);
}

/* A line's elements in a block of rows: their bounds, the sizes of their terms, and by what a flushed
 * product among those may be multiplied. */
typedef struct {
    const double *low[MAX_TERMS], *high[MAX_TERMS], *size[MAX_TERMS], *reach[MAX_TERMS];
} Elements;

/* The same with the memory for them. */
typedef struct {
    Elements at;
    ALIGNED double blocks[4][MAX_TERMS][ROWS];
} Loaded;

static void pick_all(
    const Place *place, npy_intp line, npy_intp terms, npy_intp start, npy_intp count,
    double (*blocks)[ROWS], const double **to)
{
    if (place->along == 1 && place->down == terms && terms > 2) {
        take_apart(count, terms, place->data + start * terms, blocks);
        for (npy_intp j = 0; j < terms; j++) to[j] = blocks[j];
    } else
        for (npy_intp j = 0; j < terms; j++)
            to[j] = picked(place, line, j, start, count, blocks[j]);
}

/* Takes a block of a line's elements. Where they are to be squared, no slack is paid, and only what
 * is tiny has sizes. */
static void load_elements(
    const Rows *from, npy_intp line, npy_intp start, npy_intp count, int squared, int tiny,
    Loaded *loaded)
{
    const Value *value = &from->value;
    Elements *to = &loaded->at;
    npy_intp terms = from->terms;
    pick_all(&from->lo, line, terms, start, count, loaded->blocks[0], to->low);
    if (value->exact) memcpy(to->high, to->low, sizeof to->low);
    else pick_all(&from->hi, line, terms, start, count, loaded->blocks[1], to->high);
    if (squared && !tiny) return;
    if (!value->plain) pick_all(&from->mag, line, terms, start, count, loaded->blocks[2], to->size);
    for (npy_intp j = 0; j < terms && value->plain; j++) {
        sizes(count, to->low[j], to->high[j], loaded->blocks[2][j]);
        to->size[j] = loaded->blocks[2][j];
    }
    if (tiny && value->reaching)
        pick_all(&from->reach, line, terms, start, count, loaded->blocks[3], to->reach);
    for (npy_intp j = 0; j < terms && tiny && !value->reaching; j++) {
        at_least_one(count, to->size[j], loaded->blocks[3][j]);
        to->reach[j] = loaded->blocks[3][j];
    }
    for (npy_intp j = 0; j < terms && !squared && value->slackened; j++) {
        ALIGNED double block[ROWS], low[ROWS], high[ROWS];
        const double *slack = picked(&from->slack, line, j, start, count, block);
        settle(count, to->low[j], to->high[j], slack, low, high);
        to->low[j] = memcpy(loaded->blocks[0][j], low, count * sizeof *low);
        to->high[j] = memcpy(loaded->blocks[1][j], high, count * sizeof *high);
    }
}

/* Terms of 0 from the last one on, up to `to`. */
static void fill_up(Elements *elements, npy_intp from, npy_intp to)
{
    static const ALIGNED double zeros[ROWS];
    for (npy_intp j = from; j < to; j++)
        elements->low[j] = elements->high[j] = elements->size[j] = elements->reach[j] = zeros;
}

#endif
