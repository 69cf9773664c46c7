/* What rounds nothing: minima, maxima and hulls, signs. */

#ifndef SHADERLAB_EXACTS_H
#define SHADERLAB_EXACTS_H

/* Whether a band may be NaN somewhere: NumPy sees to those. */
static int may_be_nan(PyObject *band) { return flag_of(band, 0) != NULL; }

/* Reads the bounds of one to three bands, their terms apart; false where NumPy must do it. */
static int begin_exact(
    Pass *pass, Value *values[], PyObject *const *args, Py_ssize_t given, int count)
{
    memset(&pass->shape, 0, sizeof pass->shape);
    memset(&pass->result, 0, sizeof pass->result);
    if (given != count) return 0;
    for (int k = 0; k < count; k++) {
        if (!is_band(args[k]) || may_be_nan(args[k])) return 0;
        PyObject *lo = SLOT(args[k], bands.lo), *hi = SLOT(args[k], bands.hi);
        Value *value = values[k];
        value->exact = lo == hi;
        value->plain = 1;
        value->slackened = value->reaching = 0;
        if (!is_operand(&value->lo, lo) || !broadcast(&pass->shape, &value->lo)) return 0;
        if (value->exact) continue;
        if (!is_operand(&value->hi, hi) || !broadcast(&pass->shape, &value->hi)) return 0;
    }
    if (!pass->shape.size) return 0;
    for (int k = 0; k < count; k++) prepare_value(values[k], &pass->shape);
    pass->bands[0] = args[0];
    pass->bands[1] = count > 1 ? args[1] : NULL;
    return 1;
}

static npy_intp block_at(const Shape *shape, npy_intp start)
{
    return shape->size - start < BLOCK ? shape->size - start : BLOCK;
}

LOOP int64_t minima(npy_intp count, const double *a, const double *b, double *restrict to)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        to[i] = smaller(a[i], b[i]);
        rare |= (a[i] != a[i]) | (b[i] != b[i]) ? ODD : 0;
    }
    return rare;
}

LOOP int64_t maxima(npy_intp count, const double *a, const double *b, double *restrict to)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        to[i] = larger(a[i], b[i]);
        rare |= (a[i] != a[i]) | (b[i] != b[i]) ? ODD : 0;
    }
    return rare;
}

typedef int64_t (*Chooser)(npy_intp, const double *, const double *, double *restrict);

static PyObject *chosen(PyObject *const *args, Py_ssize_t given, Chooser choose)
{
    Pass pass;
    Value *a = &pass.a, *b = &pass.b, *both[] = {a, b};
    Result *result = &pass.result;
    if (!begin_exact(&pass, both, args, given, 2)) Py_RETURN_NONE;
    if (make_room(result, &pass.shape, 0, 0)) return NULL;
    for (npy_intp start = 0; start < pass.shape.size && !result->rare; start += BLOCK) {
        npy_intp count = block_at(&pass.shape, start);
        load_bounds(a, start, count);
        load_bounds(b, start, count);
        result->rare = choose(count, a->low, b->low, result->low + start);
        result->rare |= choose(count, a->high, b->high, result->high + start);
    }
    return finished(&pass);
}

static PyObject *smaller_band(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return chosen(args, given, minima);
}

static PyObject *larger_band(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return chosen(args, given, maxima);
}

LOOP int64_t within(
    npy_intp count, const double *x, const double *least, const double *most, double *restrict to)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        to[i] = smaller(larger(x[i], least[i]), most[i]);
        rare |= (x[i] != x[i]) | !(least[i] <= most[i]) ? ODD : 0;
    }
    return rare;
}

/* clamped(x, minimum, maximum), where no minimum may exceed a maximum. */
static PyObject *clamped(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    Value third, *x = &pass.a, *least = &pass.b, *most = &third, *all[] = {x, least, most};
    Result *result = &pass.result;
    if (!begin_exact(&pass, all, args, given, 3) || args[1] == args[2]) Py_RETURN_NONE;
    if (!flagless(SLOT(args[2], bands.flags))) Py_RETURN_NONE;
    if (make_room(result, &pass.shape, 0, 0)) return NULL;
    for (npy_intp start = 0; start < pass.shape.size && !result->rare; start += BLOCK) {
        npy_intp count = block_at(&pass.shape, start);
        for (int k = 0; k < 3; k++) load_bounds(all[k], start, count);
        double *low = result->low + start, *high = result->high + start;
        result->rare = within(count, x->low, least->low, most->low, low);
        result->rare |= within(count, x->high, least->high, most->high, high);
        /* The highest minimum, against the lowest maximum. */
        if (!least->exact || !most->exact)
            result->rare |= within(count, x->low, least->high, most->low, pass.lo);
    }
    return finished(&pass);
}

LOOP int64_t sizes_between(
    npy_intp count, const double *lo, const double *hi, double *restrict low,
    double *restrict high)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double one = fabs(lo[i]), other = fabs(hi[i]);
        low[i] = (lo[i] < 0.0) & (hi[i] > 0.0) ? 0.0 : smaller(one, other);
        high[i] = larger(one, other);
        rare |= (one != one) | (other != other) ? ODD : 0;
    }
    return rare;
}

static PyObject *absolute(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    Value *a = &pass.a;
    Result *result = &pass.result;
    if (!begin_exact(&pass, &a, args, given, 1)) Py_RETURN_NONE;
    if (make_room(result, &pass.shape, 0, 0)) return NULL;
    result->exact = a->exact;
    for (npy_intp start = 0; start < pass.shape.size && !result->rare; start += BLOCK) {
        npy_intp count = block_at(&pass.shape, start);
        load_bounds(a, start, count);
        double *low = result->low + start, *high = result->high + start;
        result->rare = sizes_between(count, a->low, a->high, low, high);
    }
    return finished(&pass);
}

/* `hull` of two bands, and the greater of what their terms are. */
static PyObject *union_of(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    if (!begin(&pass, args, given, 2)) Py_RETURN_NONE;
    Value *a = &pass.a, *b = &pass.b;
    Result *result = &pass.result;
    int sums = !a->plain || !b->plain, slack = a->slackened || b->slackened;
    if (make_room(result, &pass.shape, sums, slack)) return NULL;
    if ((a->reaching || b->reaching) && reach_too(&pass)) return NULL;
    result->count = larger(a->count, b->count);
    for (npy_intp start = 0; at_block(&pass, start, 2); start += BLOCK) {
        npy_intp count = pass.count;
        result->rare = minima(count, a->low, b->low, result->low + start);
        result->rare |= maxima(count, a->high, b->high, result->high + start);
        if (sums) result->rare |= maxima(count, a->size, b->size, result->size + start);
        if (pass.tiny) maxima(count, a->reached, b->reached, result->reached + start);
        if (!slack) continue;
        static const ALIGNED double none[BLOCK];
        const double *one = a->slackened ? values_at(&a->slack, start, count) : none;
        const double *other = b->slackened ? values_at(&b->slack, start, count) : none;
        maxima(count, one, other, result->step + start);
    }
    return finished(&pass);
}

#endif
