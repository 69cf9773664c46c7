/* The ends of a mix of two values: the twin of functions.cut_to_ends. */

#ifndef SHADERLAB_MIXES_H
#define SHADERLAB_MIXES_H

/* How many operations of a mix may each flush a denormal. */
#define MIX_FLUSHED 8.0

static inline double least_mix(double low, double high, double a, double from, double to)
{
    return smaller(low * (1.0 - a), high * (1.0 - a)) + smaller(from * a, to * a);
}

static inline double greatest_mix(double low, double high, double a, double from, double to)
{
    return larger(low * (1.0 - a), high * (1.0 - a)) + larger(from * a, to * a);
}

/* The bounds of x·(1 - a) + y·a by the ends of x, y and a, moved out by the roundings; `terms` and
 * `reach` are of the mix as it was computed where flushed products may reach far, else 0 and 1. */
LOOP int64_t mix_ends(
    npy_intp count, const Value *x, const Value *y, const Value *a, const double *terms,
    const double *reach, double unit, double *restrict lo, double *restrict negated_hi)
{
    const double *x_lo = x->settled_low, *x_hi = x->settled_high, *x_size = x->size;
    const double *y_lo = y->settled_low, *y_hi = y->settled_high, *y_size = y->size;
    const double *a_lo = a->settled_low, *a_hi = a->settled_high, *a_size = a->size;
    double others = x->count + y->count - 2.0;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double share = smaller(larger(fabs(a_lo[i]), fabs(a_hi[i])), LARGEST);
        double both = (x_size[i] + y_size[i]) * share;
        double sums = 3.0 * (x_size[i] + both) + others * both;
        double weights = x_size[i] * (1.0 + a_size[i]) + y_size[i] * a_size[i];
        double lost = larger(RELATIVE_STEP * (sums + weights), MIX_FLUSHED * SMALLEST_NORMAL);
        lost = larger(lost, MIX_FLUSHED * step_of(terms[i], unit * reach[i], 1));
        lost = a_size[i] > 0.0 ? lost : 0.0;
        double low = smaller(least_mix(x_lo[i], x_hi[i], a_lo[i], y_lo[i], y_hi[i]),
                             least_mix(x_lo[i], x_hi[i], a_hi[i], y_lo[i], y_hi[i])) - lost;
        double high = larger(greatest_mix(x_lo[i], x_hi[i], a_lo[i], y_lo[i], y_hi[i]),
                             greatest_mix(x_lo[i], x_hi[i], a_hi[i], y_lo[i], y_hi[i])) + lost;
        lo[i] = low;
        negated_hi[i] = -high;
        rare |= unbounded(x_lo[i], x_hi[i]) | unbounded(y_lo[i], y_hi[i]) ? -1 : 0;
        rare |= unbounded(a_lo[i], a_hi[i]) | unbounded(low, high) ? -1 : 0;
    }
    return rare;
}

LOOP void cut(
    npy_intp count, const double *low, const double *high, double *restrict lo, double *restrict hi)
{
    for (npy_intp i = 0; i < count; i++) {
        lo[i] = larger(lo[i], low[i]);
        hi[i] = smaller(hi[i], high[i]);
    }
}

/* The sizes of a mix's terms: those of x, and products with the share. */
LOOP int64_t mix_sizes(
    npy_intp count, const Value *found, const Value *x, const Value *y, const Value *a,
    double *restrict size)
{
    const double *lo = found->low, *hi = found->high, *x_size = x->size, *a_size = a->size;
    const double *x_lo = x->settled_low, *x_hi = x->settled_high;
    const double *y_lo = y->settled_low, *y_hi = y->settled_high;
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double near = smaller(larger(fabs(x_lo[i]), fabs(x_hi[i])), LARGEST);
        double far = smaller(larger(fabs(y_lo[i]), fabs(y_hi[i])), LARGEST);
        double terms = x_size[i] + (near + far) * a_size[i];
        double own = smaller(larger(fabs(lo[i]), fabs(hi[i])), LARGEST);
        double mag = smaller(larger(terms, own), LARGEST);
        size[i] = mag;
        rare |= rare_of(!(terms < INFINITY), mag);
    }
    return rare;
}

/* within_ends(found, x, y, a): the band `found` of a mix, cut to what its operands' ends allow. */
static PyObject *within_ends(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    Value x, y, a, *found = &pass.a, *all[] = {found, &x, &y, &a};
    Result *result = &pass.result;
    ALIGNED double zeros[BLOCK] = {0}, ones[BLOCK];
    if (given != 4 || !begin(&pass, args, 1, 1) || found->exact) Py_RETURN_NONE;
    for (int k = 1; k < 4; k++)
        if (!read_value(all[k], args[k]) || !broadcast_value(&pass.shape, all[k])) Py_RETURN_NONE;
    for (int k = 0; k < 4; k++) prepare_value(all[k], &pass.shape);
    if (make_room(result, &pass.shape, !found->plain, 0)) return NULL;
    if (found->reaching)
        result->reach = (PyArrayObject *)Py_NewRef((PyObject *)found->reach.array);
    result->count = x.count + 2.0;
    at_least_one(BLOCK, zeros, ones);
    double unit = SMALLEST_NORMAL * (found->reaching ? found->count : 1.0);
    for (npy_intp start = 0; start < pass.shape.size && !result->rare; start += BLOCK) {
        npy_intp count = pass.shape.size - start < BLOCK ? pass.shape.size - start : BLOCK;
        for (int k = 0; k < 4; k++) load(all[k], start, count);
        if (found->reaching) load_reach(found, start, count);
        result->rare = mix_ends(
            count, &x, &y, &a, found->reaching ? found->size : zeros,
            found->reaching ? found->reached : ones, unit, pass.lo, pass.negated_hi);
        if (!found->plain) {
            int64_t rare = mix_sizes(count, found, &x, &y, &a, result->size + start);
            result->rare |= found->reaching ? rare & ODD : rare;
        }
        double *low = result->low + start, *high = result->high + start;
        narrow(count, result->flush, pass.lo, pass.negated_hi, low, high);
        cut(count, found->low, found->high, low, high);
    }
    return finished(&pass);
}

#endif
