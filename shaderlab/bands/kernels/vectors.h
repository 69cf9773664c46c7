/* The products of rows: of two vectors, and of a matrix and a vector. Each row has a vector or matrix
 * of its own, or all have the same. */

#ifndef SHADERLAB_VECTORS_H
#define SHADERLAB_VECTORS_H

typedef struct {
    Rows a, b;
    Products how;
    Kind kind;
    int tiny;
    /* Which elements of the vectors a factor of 0 leaves out. */
    int skipped[MAX_TERMS];
    Loaded factors, elements;
    Sums sums;
} Line;

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
    const Value *a = &line->a.value, *b = &line->b.value;
    line->kind = args[0] == args[1] ? SQUARE : EACH;
    line->tiny = a->reaching || b->reaching;
    line->how.flush = is_rule(rules, rule_sets.flush);
    line->how.terms = (int)line->b.terms;
    line->how.unit = SMALLEST_NORMAL * (a->count * b->count);
    /* How many roundings a product of these takes among its terms. */
    if (line->kind == SQUARE) line->how.steps = !b->plain && !b->exact ? 1.0 : 0.0;
    else if (a->plain && b->plain) line->how.steps = 0.0;
    else line->how.steps = a->plain || b->plain ? 1.0 : larger(3.0, a->count * b->count - 1.0);
    return 1;
}

/* Where all rows have the same exact factors, those of 0 leave nothing of a finite number. */
static void find_shared(Line *line)
{
    const Value *a = &line->a.value;
    const Place *place = &line->a.lo;
    memset(line->skipped, 0, sizeof line->skipped);
    if (line->kind == SQUARE) return;
    line->kind = !line->tiny && !place->down && a->exact && a->plain ? SHARED : EACH;
    for (npy_intp number = 0; number < line->a.lines && line->kind == SHARED; number++)
        for (npy_intp j = 0; j < line->a.terms; j++)
            line->skipped[j] |= place->data[number * place->line + j * place->along] == 0.0;
}

LOOP int64_t any_infinite(npy_intp count, const double *low, const double *high, const double *size)
{
    int64_t found = 0;
    for (npy_intp i = 0; i < count; i++)
        found |= !(fabs(low[i]) + fabs(high[i]) + size[i] < INFINITY) ? ODD : 0;
    return found;
}

/* Makes the elements of a block of rows the current ones; what is rare in them. */
static int64_t load_vectors(Line *line, npy_intp start, npy_intp count)
{
    Elements *b = &line->elements.at;
    int64_t rare = 0;
    load_elements(&line->b, 0, start, count, line->kind == SQUARE, line->tiny, &line->elements);
    for (npy_intp j = 0; j < line->b.terms; j++)
        if (line->skipped[j]) rare |= any_infinite(count, b->low[j], b->high[j], b->size[j]);
    fill_up(b, line->b.terms, 3);
    return rare;
}

/* The sums of one line of a block of rows; what is rare. */
static int64_t sum_line(
    Line *line, npy_intp number, npy_intp start, npy_intp count, double *low, double *high)
{
    int terms = (int)line->b.terms;
    const Place *place = &line->a.lo;
    const Elements *from = &line->elements.at, *b = from;
    Elements *a = &line->factors.at, chosen;
    double shared[MAX_TERMS], size[MAX_TERMS];
    if (line->kind == EACH) {
        load_elements(&line->a, number, start, count, 0, line->tiny, &line->factors);
        fill_up(a, terms, 3);
    } else if (line->kind == SHARED) {
        b = &chosen;
        terms = 0;
        for (npy_intp j = 0; j < line->b.terms; j++) {
            double factor = place->data[number * place->line + j * place->along];
            if (factor == 0.0) continue;
            shared[terms] = factor;
            size[terms] = smaller(fabs(factor), LARGEST);
            a->low[terms] = &shared[terms];
            a->size[terms] = &size[terms];
            chosen.low[terms] = from->low[j];
            chosen.high[terms] = from->high[j];
            chosen.size[terms++] = from->size[j];
        }
        fill_up(a, terms, 3);
        fill_up(&chosen, terms, 3);
    }
    return add_up(count, &line->how, line->kind, terms, line->tiny, a, b, &line->sums, low, high);
}

/* All lines of a block of rows; what is rare. */
static int64_t sum_lines(Line *line, Result *result, npy_intp start, npy_intp count)
{
    ALIGNED double low[MAX_TERMS][ROWS], high[MAX_TERMS][ROWS], size[MAX_TERMS][ROWS];
    ALIGNED double slack[MAX_TERMS][ROWS], reach[MAX_TERMS][ROWS];
    Sums *sums = &line->sums;
    npy_intp lines = line->a.lines, at = start * lines;
    int64_t rare = load_vectors(line, start, count);
    if (lines == 1) {
        sums->size = result->size + start;
        sums->slack = result->step + start;
        if (line->tiny) sums->reach = result->reached + start;
        return rare | sum_line(line, 0, start, count, result->low + start, result->high + start);
    }
    for (npy_intp number = 0; number < lines; number++) {
        sums->size = size[number];
        sums->slack = slack[number];
        sums->reach = reach[number];
        rare |= sum_line(line, number, start, count, low[number], high[number]);
    }
    put_blocks_together(count, lines, low, result->low + at);
    put_blocks_together(count, lines, high, result->high + at);
    put_blocks_together(count, lines, size, result->size + at);
    put_blocks_together(count, lines, slack, result->step + at);
    if (line->tiny) put_blocks_together(count, lines, reach, result->reached + at);
    return rare;
}

static PyObject *sum_products(PyObject *const *args, Py_ssize_t given, int lines)
{
    Pass pass;
    Line line;
    Result *result = &pass.result;
    if (!begin_rows(&line, &pass, args, given, lines)) Py_RETURN_NONE;
    Value *a = &line.a.value, *b = &line.b.value;
    int scales = line.kind != SQUARE && (is_scale(a) || is_scale(b));
    if (scales) {
        /* Factors that round nothing leave a pending slack and tiny terms as they are. */
        if (a->slackened || b->slackened || line.tiny) Py_RETURN_NONE;
        line.how.steps = 0.0;
    }
    npy_intp rows = line.a.rows > line.b.rows ? line.a.rows : line.b.rows;
    int single = PyArray_NDIM(line.a.value.lo.array) == 1 + lines
        && PyArray_NDIM(line.b.value.lo.array) == 1;
    pass.shape = (Shape){.ndim = 2, .dims = {rows, line.a.lines}, .size = rows * line.a.lines};
    if (single) pass.shape = (Shape){.ndim = 1, .dims = {line.a.lines}, .size = line.a.lines};
    if (make_room(result, &pass.shape, 1, 1)) return NULL;
    result->count = (double)line.b.terms;
    for (;;) {
        find_shared(&line);
        if (line.tiny && reach_too(&pass)) return NULL;
        for (npy_intp start = 0; start < rows && !result->rare; start += ROWS) {
            npy_intp count = rows - start < ROWS ? rows - start : ROWS;
            result->rare = sum_lines(&line, result, start, count);
        }
        if (line.tiny || scales || result->rare != TINY_TERMS) return finished(&pass);
        line.tiny = 1;
    }
}

/* dot(a, b) of vectors; the one that all rows share is the first. */
static PyObject *dot(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    if (given != 2 || !is_band(args[0]) || !is_band(args[1])) Py_RETURN_NONE;
    PyArrayObject *other = (PyArrayObject *)SLOT(args[1], bands.lo);
    int shared = PyArray_NDIM(other) == 1 || PyArray_DIM(other, 0) == 1;
    PyObject *const pair[] = {args[shared], args[!shared]};
    return sum_products(pair, 2, 0);
}

/* times_vector(m, v), of a matrix and a vector. */
static PyObject *times_vector(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return sum_products(args, given, 1);
}

#endif
