/* What functions of two bounds take: rounding outward, and widening by ULPs. */

#ifndef SHADERLAB_BOUNDS_H
#define SHADERLAB_BOUNDS_H

/* Two arrays of bounds of one shape, no bands. */
static int begin_bounds(Pass *pass, PyObject *const *args)
{
    memset(&pass->shape, 0, sizeof pass->shape);
    memset(&pass->result, 0, sizeof pass->result);
    pass->tiny = 0;
    Value *a = &pass->a;
    a->exact = args[0] == args[1];
    a->plain = 1;
    a->slackened = a->reaching = 0;
    if (!is_operand(&a->lo, args[0]) || !is_operand(&a->hi, args[1])) return 0;
    if (!PyArray_SAMESHAPE(a->lo.array, a->hi.array)) return 0;
    if (!broadcast(&pass->shape, &a->lo) || !pass->shape.size) return 0;
    prepare_value(a, &pass->shape);
    return 1;
}

static PyObject *two_arrays(Result *result)
{
    if (!succeeded(result)) Py_RETURN_NONE;
    return Py_BuildValue("NN", result->lo, result->hi);
}

LOOP int64_t any_crossed(npy_intp count, const double *lo, const double *hi)
{
    int64_t found = 0;
    for (npy_intp i = 0; i < count; i++) found |= !(lo[i] <= hi[i]) ? ODD : 0;
    return found;
}

static PyObject *rounded_outward(PyObject *const *args, Py_ssize_t given, int in_order)
{
    Pass pass;
    Value *a = &pass.a;
    Result *result = &pass.result;
    if (given != 3 || !begin_bounds(&pass, args)) Py_RETURN_NONE;
    if (make_room(result, &pass.shape, 0, 0)) return NULL;
    result->flush = args[2] == Py_True;
    result->exact = a->exact;
    for (npy_intp start = 0; start < pass.shape.size && !result->rare; start += BLOCK) {
        npy_intp count = pass.shape.size - start < BLOCK ? pass.shape.size - start : BLOCK;
        const double *lo = values_at(&a->lo, start, count);
        const double *hi = a->exact ? lo : values_at(&a->hi, start, count);
        if (in_order) result->rare = any_crossed(count, lo, hi);
        negated(count, hi, pass.negated_hi);
        result->differ |= narrow(count, result->flush, lo, pass.negated_hi, result->low + start,
                                 result->high + start);
    }
    return two_arrays(result);
}

/* outward(lo, hi, flush): (lo, hi), one array twice where one was given and nothing was rounded. */
static PyObject *outward(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return rounded_outward(args, given, 0);
}

/* enclosed(lo, hi, flush): the same of bounds in order; None where one is no number. */
static PyObject *enclosed(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return rounded_outward(args, given, 1);
}

/* Arrays of one joint shape; false where a pass can't take them. */
static int read_operands(Operand *operands, PyObject *const *args, int count, Shape *shape)
{
    memset(shape, 0, sizeof *shape);
    for (int i = 0; i < count; i++)
        if (!is_operand(&operands[i], args[i]) || !broadcast(shape, &operands[i])) return 0;
    if (!shape->size) return 0;
    for (int i = 0; i < count; i++) prepare(&operands[i], shape);
    return 1;
}

LOOP int64_t widen_block(
    npy_intp count, const double *lo, const double *hi, const double *ulps_lo,
    const double *ulps_hi, double *restrict out_lo, double *restrict out_hi)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double low = lo[i], high = hi[i];
        rare |= unbounded(low, low) | unbounded(high, high) ? -1 : 0;
        widen(&low, &high, ulps_lo[i], ulps_hi[i]);
        out_lo[i] = low;
        out_hi[i] = high;
    }
    return rare;
}

/* The ULPs for a block: of an array, or one number for all. */
static int read_ulps(Operand *operand, PyObject *ulps, const Shape *shape)
{
    if (PyFloat_Check(ulps)) {
        double number = PyFloat_AS_DOUBLE(ulps);
        for (int i = 0; i < BLOCK; i++) operand->block[i] = number;
        operand->kind = REPEATED;
        return 1;
    }
    Shape joint = *shape;
    if (!is_operand(operand, ulps) || !broadcast(&joint, operand)) return 0;
    if (joint.size != shape->size || joint.ndim != shape->ndim) return 0;
    prepare(operand, shape);
    return 1;
}

/* widened_by_ulps(lo, hi, ulps_lo, ulps_hi): (lo, hi); None where a bound is no number. */
static PyObject *widened_by_ulps(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    Value *a = &pass.a;
    Operand ulps_lo, ulps_hi;
    Result *result = &pass.result;
    if (given != 4 || !begin_bounds(&pass, args)) Py_RETURN_NONE;
    if (!read_ulps(&ulps_lo, args[2], &pass.shape)) Py_RETURN_NONE;
    if (!read_ulps(&ulps_hi, args[3], &pass.shape)) Py_RETURN_NONE;
    if (make_room(result, &pass.shape, 0, 0)) return NULL;
    for (npy_intp start = 0; start < pass.shape.size && !result->rare; start += BLOCK) {
        npy_intp count = pass.shape.size - start < BLOCK ? pass.shape.size - start : BLOCK;
        const double *lo = values_at(&a->lo, start, count);
        const double *hi = a->exact ? lo : values_at(&a->hi, start, count);
        result->rare = widen_block(
            count, lo, hi, values_at(&ulps_lo, start, count), values_at(&ulps_hi, start, count),
            result->low + start, result->high + start);
    }
    return two_arrays(result);
}

#define LOG_ERROR_NEAR_ONE 0x1p-21
#define LOG_ULPS 3.0

static inline double log_error(double a, double logarithm)
{
    double error = LOG_ULPS * ulp(logarithm);
    return (a >= 0.5) & (a <= 2.0) ? LOG_ERROR_NEAR_ONE : error;
}

LOOP int64_t widen_logarithms(
    npy_intp count, const double *a_lo, const double *a_hi, const double *from, const double *to,
    double *restrict lo, double *restrict hi)
{
    for (npy_intp i = 0; i < count; i++) {
        double low = a_lo[i], high = a_hi[i];
        double error = larger(log_error(low, from[i]), log_error(high, to[i]));
        /* Just inside 1/2 and 2 more is allowed than just outside. */
        int crosses = ((low < 0.5) & (high >= 0.5)) | ((low <= 2.0) & (high > 2.0));
        error = crosses ? larger(error, LOG_ERROR_NEAR_ONE) : error;
        lo[i] = from[i] - (error + FLOAT64_ERROR * fabs(from[i]));
        hi[i] = to[i] + (error + FLOAT64_ERROR * fabs(to[i]));
    }
    return 0;
}

#define EXP_ULPS 3.0

LOOP int64_t widen_exponentials(
    npy_intp count, const double *a_lo, const double *a_hi, const double *from, const double *to,
    double *restrict lo, double *restrict hi)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double low = from[i], high = to[i];
        double ulps_lo = EXP_ULPS + 2.0 * smaller(fabs(a_lo[i]), LARGEST);
        double ulps_hi = EXP_ULPS + 2.0 * smaller(fabs(a_hi[i]), LARGEST);
        rare |= unbounded(low, low) | unbounded(high, high) ? ODD : 0;
        widen(&low, &high, ulps_lo, ulps_hi);
        lo[i] = larger(low, 0.0);
        hi[i] = larger(high, SMALLEST_DENORMAL);
    }
    return rare;
}

typedef int64_t (*Widener)(
    npy_intp, const double *, const double *, const double *, const double *, double *restrict,
    double *restrict);

/* The function's values at both ends, moved out: (lo, hi). */
static PyObject *widened_ends(PyObject *const *args, Py_ssize_t given, Widener widen_ends)
{
    Operand operands[4];
    const double *at[4];
    Shape shape;
    Result result = {0};
    if (given != 4 || !read_operands(operands, args, 4, &shape)) Py_RETURN_NONE;
    if (make_room(&result, &shape, 0, 0)) return NULL;
    for (npy_intp start = 0; start < shape.size && !result.rare; start += BLOCK) {
        npy_intp count = shape.size - start < BLOCK ? shape.size - start : BLOCK;
        for (int k = 0; k < 4; k++) at[k] = values_at(&operands[k], start, count);
        result.rare = widen_ends(
            count, at[0], at[1], at[2], at[3], result.low + start, result.high + start);
    }
    return two_arrays(&result);
}

/* logarithms_widened(a_lo, a_hi, lo, hi). */
static PyObject *logarithms_widened(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return widened_ends(args, given, widen_logarithms);
}

/* exponentials_widened(a_lo, a_hi, lo, hi). */
static PyObject *exponentials_widened(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    return widened_ends(args, given, widen_exponentials);
}

#endif
