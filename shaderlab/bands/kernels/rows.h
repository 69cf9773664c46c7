/* Sums of products along rows, without the products in memory: a dot product, a matrix times a
 * vector. Each row has a vector or matrix of its own, or all have the same. */

#ifndef SHADERLAB_ROWS_H
#define SHADERLAB_ROWS_H

#define MAX_TERMS 4

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
    if (rows->terms < 2 || rows->terms > MAX_TERMS || !rows->rows || !rows->lines) return 0;
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

/* Makes one element of a block of rows the current block of `to`, which has the memory for it. */
static void load_element(
    const Rows *from, npy_intp line, npy_intp term, npy_intp start, npy_intp count, int tiny,
    Value *to)
{
    const Value *value = &from->value;
    to->low = picked(&from->lo, line, term, start, count, to->lo.block);
    to->high = value->exact ? to->low : picked(&from->hi, line, term, start, count, to->hi.block);
    to->count = value->count;
    to->plain = value->plain;
    to->settled_low = to->low;
    to->settled_high = to->high;
    if (value->slackened) {
        const double *slack = picked(&from->slack, line, term, start, count, to->slack.block);
        settle(count, to->low, to->high, slack, to->blocks[0], to->blocks[1]);
        to->settled_low = to->blocks[0];
        to->settled_high = to->blocks[1];
    }
    to->size = to->blocks[2];
    if (value->plain) sizes(count, to->low, to->high, to->blocks[2]);
    else to->size = picked(&from->mag, line, term, start, count, to->mag.block);
    if (!tiny) return;
    to->reached = to->blocks[3];
    if (value->reaching)
        to->reached = picked(&from->reach, line, term, start, count, to->reach.block);
    else at_least_one(count, to->size, to->blocks[3]);
}

/* What a line's products are added up in; and the product itself. */
typedef struct {
    Rows a, b;
    int squares, tiny, flush;
    /* Whether factors of 0, which leave nothing of a finite number, are passed over. */
    int skips;
    double steps;
    Value element, elements[MAX_TERMS], product;
    Total total;
    ALIGNED double lo[BLOCK], negated_hi[BLOCK], size[BLOCK], slack[BLOCK];
} Line;

/* Makes the product of two elements, or the square of one, the current block of `product`. */
static int64_t multiply_element(Line *line, const Value *a, const Value *b, npy_intp count)
{
    Value *product = &line->product;
    double *lo = line->lo, *negated_hi = line->negated_hi, *size = product->blocks[2];
    double *reach = product->blocks[3], steps = line->steps;
    int64_t rare = 0;
    if (line->squares && line->tiny) rare = square_tiny(count, b, steps, lo, negated_hi, size, reach);
    else if (line->squares) rare = square_block(count, b, steps, lo, negated_hi, size);
    else if (line->tiny) rare = multiply_tiny(count, a, b, steps, lo, negated_hi, size, reach);
    else rare = multiply_block(count, a, b, steps, lo, negated_hi, size);
    narrow(count, line->flush, lo, negated_hi, product->blocks[0], product->blocks[1]);
    product->settled_low = product->blocks[0];
    product->settled_high = product->blocks[1];
    product->size = size;
    product->reached = reach;
    return rare;
}

LOOP int64_t any_infinite(npy_intp count, const Value *a)
{
    const double *low = a->settled_low, *high = a->settled_high, *size = a->size;
    int64_t found = 0;
    for (npy_intp i = 0; i < count; i++)
        found |= !(fabs(low[i]) + fabs(high[i]) + size[i] < INFINITY) ? ODD : 0;
    return found;
}

/* Makes the elements of a block of rows the current ones; what is rare in them. */
static int64_t load_vectors(Line *line, npy_intp start, npy_intp count)
{
    int64_t rare = 0;
    for (npy_intp j = 0; j < line->b.terms; j++) {
        load_element(&line->b, 0, j, start, count, line->tiny, &line->elements[j]);
        if (line->skips) rare |= any_infinite(count, &line->elements[j]);
    }
    return rare;
}

static int is_skipped(const Line *line, npy_intp number, npy_intp term)
{
    const Place *place = &line->a.lo;
    return line->skips && place->data[number * place->line + term * place->along] == 0.0;
}

/* The sums of one line of a block of rows, rounded outward into `low` and `high`; what is rare. */
static int64_t add_up(
    Line *line, npy_intp number, npy_intp start, npy_intp count, double *low, double *high)
{
    int64_t rare = 0;
    Total *total = &line->total;
    npy_intp terms = line->b.terms, added = 0;
    for (npy_intp j = 0; j < terms; j++) {
        if (is_skipped(line, number, j)) continue;
        if (!line->squares)
            load_element(&line->a, number, j, start, count, line->tiny, &line->element);
        rare |= multiply_element(line, &line->element, &line->elements[j], count);
        add_term(total, &line->product, count, added++ == 0, line->tiny);
    }
    if (!added) memset(total, 0, sizeof *total);
    rare |= end_sum(count, total, line->tiny ? SMALLEST_NORMAL * (double)terms : 0.0, line->lo,
                    line->negated_hi, line->size, line->slack);
    narrow(count, line->flush, line->lo, line->negated_hi, low, high);
    return rare;
}

/* Reads both operands; false where the pass can't take them. */
static int begin_rows(
    Line *line, Pass *pass, PyObject *const *args, Py_ssize_t given, int lines)
{
    memset(&pass->shape, 0, sizeof pass->shape);
    memset(&pass->result, 0, sizeof pass->result);
    if (given != 2 || !read_value(&line->a.value, args[0])) return 0;
    if (!read_value(&line->b.value, args[1])) return 0;
    PyObject *rules = SLOT(args[0], bands.rules);
    if (!Py_IS_TYPE(rules, rule_sets.type) || !is_rule(rules, rule_sets.rearrange)) return 0;
    for (int k = 0; k < 2; k++) {
        pass->bands[k] = args[k];
        if (!flagless(SLOT(args[k], bands.flags))) return 0;
    }
    if (!find_rows(&line->a, lines) || !find_rows(&line->b, 0)) return 0;
    npy_intp a_rows = line->a.rows, b_rows = line->b.rows;
    if (line->a.terms != line->b.terms) return 0;
    if (a_rows != b_rows && a_rows != 1 && b_rows != 1) return 0;
    line->flush = is_rule(rules, rule_sets.flush);
    line->squares = args[0] == args[1];
    line->tiny = line->a.value.reaching || line->b.value.reaching;
    return 1;
}

/* How many roundings a product of these takes among its terms. */
static double steps_of(const Line *line)
{
    const Value *a = &line->a.value, *b = &line->b.value;
    if (line->squares) return !b->plain && !b->exact ? 1.0 : 0.0;
    if (a->plain && b->plain) return 0.0;
    return a->plain || b->plain ? 1.0 : larger(3.0, a->count * b->count - 1.0);
}

LOOP void spread(npy_intp count, const double *from, npy_intp stride, double *restrict to)
{
    switch (stride) {
    case 1: for (npy_intp i = 0; i < count; i++) to[i] = from[i]; break;
    case 3: for (npy_intp i = 0; i < count; i++) to[3 * i] = from[i]; break;
    case 4: for (npy_intp i = 0; i < count; i++) to[4 * i] = from[i]; break;
    default: for (npy_intp i = 0; i < count; i++) to[i * stride] = from[i];
    }
}

/* All lines of all rows. */
static int64_t add_up_all(Line *line, Result *result, npy_intp rows, npy_intp lines)
{
    int64_t rare = 0;
    ALIGNED double low[BLOCK], high[BLOCK];
    for (npy_intp start = 0; start < rows && !rare; start += BLOCK) {
        npy_intp count = rows - start < BLOCK ? rows - start : BLOCK;
        rare = load_vectors(line, start, count);
        for (npy_intp number = 0; number < lines; number++) {
            rare |= add_up(line, number, start, count, low, high);
            npy_intp at = start * lines + number;
            spread(count, low, lines, result->low + at);
            spread(count, high, lines, result->high + at);
            spread(count, line->size, lines, result->size + at);
            spread(count, line->slack, lines, result->step + at);
            if (line->tiny) spread(count, line->total.reach, lines, result->reached + at);
        }
    }
    return rare;
}

static PyObject *sum_products(PyObject *const *args, Py_ssize_t given, int lines)
{
    Pass pass;
    Line line;
    Result *result = &pass.result;
    if (!begin_rows(&line, &pass, args, given, lines)) Py_RETURN_NONE;
    /* Factors that round nothing leave more of the terms as they are. */
    if (!line.squares && (is_scale(&line.a.value) || is_scale(&line.b.value))) Py_RETURN_NONE;
    npy_intp rows = line.a.rows > line.b.rows ? line.a.rows : line.b.rows;
    int single = PyArray_NDIM(line.a.value.lo.array) == 1 + lines
        && PyArray_NDIM(line.b.value.lo.array) == 1;
    pass.shape = (Shape){.ndim = 2, .dims = {rows, line.a.lines}, .size = rows * line.a.lines};
    if (single) pass.shape = (Shape){.ndim = 1, .dims = {line.a.lines}, .size = line.a.lines};
    line.steps = steps_of(&line);
    if (make_room(result, &pass.shape, 1, 1)) return NULL;
    result->count = (double)line.b.terms;
    for (;;) {
        const Value *a = &line.a.value;
        line.skips = !line.squares && !line.tiny && !line.a.lo.down && a->exact && a->plain;
        if (line.tiny && reach_too(&pass)) return NULL;
        result->rare = add_up_all(&line, result, rows, line.a.lines);
        if (line.tiny || result->rare != TINY_TERMS) return finished(&pass);
        line.tiny = 1;
    }
}

/* dot(a, b) of vectors. */
static PyObject *dot(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return sum_products(args, given, 0);
}

/* times_vector(m, v), of a matrix and a vector. */
static PyObject *times_vector(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return sum_products(args, given, 1);
}

#endif
