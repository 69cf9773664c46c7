/* The direction of a vector: v / √(v·v) and v · 1/√(v·v) together. */

#ifndef SHADERLAB_DIRECTIONS_H
#define SHADERLAB_DIRECTIONS_H

/* What rounding may add to a component of a unit vector, in both of its expansions. */
#define BEYOND_UNIT (1.0 + 16 * 0x1p-23)

/* The hull of both expansions of a component, cut; rounding it outward is rounding each. Lengths
 * whose squares are normal numbers are divisors that have a precision, and positive. */
LOOP int64_t either_component(
    npy_intp count, const double *v_lo, const double *v_hi, const Value *root, const Value *inverse,
    double *restrict lo, double *restrict negated_hi)
{
    const double *by_lo = root->low, *by_hi = root->high, *of_lo = inverse->low;
    const double *of_hi = inverse->high;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        int falls = v_lo[i] < 0.0, rises = v_hi[i] >= 0.0;
        double low = v_lo[i] / (falls ? by_lo[i] : by_hi[i]);
        double high = v_hi[i] / (rises ? by_lo[i] : by_hi[i]);
        double least = v_lo[i] * (falls ? of_hi[i] : of_lo[i]);
        double most = v_hi[i] * (rises ? of_hi[i] : of_lo[i]);
        rare |= unbounded(low, high) | unbounded(least, most) ? ODD : 0;
        widen(&low, &high, DIVISION_ULPS, DIVISION_ULPS);
        lo[i] = smaller(larger(smaller(low, least), -BEYOND_UNIT), BEYOND_UNIT);
        negated_hi[i] = -smaller(larger(larger(high, most), -BEYOND_UNIT), BEYOND_UNIT);
    }
    return rare;
}

LOOP int64_t any_less(npy_intp count, const double *x, double least)
{
    int64_t found = 0;
    for (npy_intp i = 0; i < count; i++) found |= !(x[i] >= least) ? ODD : 0;
    return found;
}

/* Lengths and their inverses, of squared lengths. */
static int64_t lengths(Line *line, const Value *squared, npy_intp count, Value *root, Value *inverse)
{
    double *lo = line->sums.low, *negated_hi = line->sums.negated_high;
    int flush = line->how.flush;
    ALIGNED double least[ROWS], greatest[ROWS];
    int64_t rare = any_less(count, squared->low, SMALLEST_NORMAL);
    rare |= inverse_root_bounds(count, squared, SMALLEST_NORMAL, lo, negated_hi);
    narrow(count, flush, lo, negated_hi, inverse->blocks[0], inverse->blocks[1]);
    narrow(count, 0, lo, negated_hi, least, greatest);
    roots(count, squared, least, greatest, lo, negated_hi);
    narrow(count, flush, lo, negated_hi, root->blocks[0], root->blocks[1]);
    for (Value *value = root;; value = inverse) {
        value->low = value->blocks[0];
        value->high = value->blocks[1];
        if (value == inverse) return rare;
    }
}

/* The components of the directions of a block of rows; what is rare in it. */
static int64_t directed(Line *line, Result *result, npy_intp start, npy_intp count)
{
    Value *squared = &line->a.value, root, inverse;
    const Elements *v = &line->elements.at;
    double *lo = line->sums.low, *negated_hi = line->sums.negated_high;
    ALIGNED double low[MAX_TERMS][ROWS], high[MAX_TERMS][ROWS], unused[3][ROWS];
    npy_intp terms = line->b.terms;
    line->sums.size = unused[0];
    line->sums.slack = unused[1];
    line->sums.reach = unused[2];
    int64_t rare = load_vectors(line, start, count);
    rare |= sum_line(line, 0, start, count, squared->blocks[0], squared->blocks[1]);
    squared->low = squared->blocks[0];
    squared->high = squared->blocks[1];
    rare |= lengths(line, squared, count, &root, &inverse);
    for (npy_intp j = 0; j < terms; j++) {
        rare |= either_component(count, v->low[j], v->high[j], &root, &inverse, lo, negated_hi);
        narrow(count, line->how.flush, lo, negated_hi, low[j], high[j]);
    }
    put_blocks_together(count, terms, low, result->low + start * terms);
    put_blocks_together(count, terms, high, result->high + start * terms);
    return rare;
}

/* direction(v), of a band without terms, where no length may be 0. */
static PyObject *direction(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    Line line;
    Result *result = &pass.result;
    if (given != 1) Py_RETURN_NONE;
    PyObject *const twice[] = {args[0], args[0]};
    if (!begin_rows(&line, &pass, twice, 2, 0) || !line.b.value.plain) Py_RETURN_NONE;
    pass.bands[1] = NULL;
    npy_intp rows = line.b.rows;
    broadcast(&pass.shape, &line.b.value.lo);
    find_shared(&line);
    if (make_room(result, &pass.shape, 0, 0)) return NULL;
    for (;;) {
        result->rare = 0;
        for (npy_intp start = 0; start < rows && !result->rare; start += ROWS) {
            npy_intp count = rows - start < ROWS ? rows - start : ROWS;
            result->rare = directed(&line, result, start, count);
        }
        if (line.tiny || result->rare != TINY_TERMS) return finished(&pass);
        line.tiny = 1;
    }
}

#endif
