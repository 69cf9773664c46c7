/* Sums along the last axis. */

#ifndef SHADERLAB_TOTALS_H
#define SHADERLAB_TOTALS_H

/* What the terms of sums over the last axis come to. */
typedef struct {
    ALIGNED double lo[BLOCK], negated_hi[BLOCK], size[BLOCK], terms[BLOCK], positive[BLOCK],
    negative[BLOCK], reach[BLOCK];
} Total;

LOOP void first_term(npy_intp count, const Value *a, Total *restrict total)
{
    const double *low = a->settled_low, *high = a->settled_high, *size = a->size;
    for (npy_intp i = 0; i < count; i++) {
        total->lo[i] = low[i];
        total->negated_hi[i] = -high[i];
        total->size[i] = size[i];
        total->terms[i] = size[i] > 0.0 ? 1.0 : 0.0;
        total->positive[i] = low[i] >= 0.0 ? 1.0 : 0.0;
        total->negative[i] = high[i] <= 0.0 ? 1.0 : 0.0;
    }
}

/* Called while the processor rounds downward. */
LOOP void add_bounds(npy_intp count, const Value *a, Total *restrict total)
{
    const double *low = a->settled_low, *high = a->settled_high;
    for (npy_intp i = 0; i < count; i++) {
        total->lo[i] += low[i];
        total->negated_hi[i] -= high[i];
    }
}

LOOP void add_sizes(npy_intp count, const Value *a, Total *restrict total)
{
    const double *low = a->settled_low, *high = a->settled_high, *size = a->size;
    for (npy_intp i = 0; i < count; i++) {
        total->lo[i] += 0.0;
        total->size[i] += size[i];
        total->terms[i] += size[i] > 0.0 ? 1.0 : 0.0;
        total->positive[i] = low[i] >= 0.0 ? total->positive[i] : 0.0;
        total->negative[i] = high[i] <= 0.0 ? total->negative[i] : 0.0;
    }
}

LOOP void add_reach(npy_intp count, const double *reach, double *restrict total)
{
    for (npy_intp i = 0; i < count; i++) total[i] += reach[i];
}

/* `unit` is what a flushed product may change; 0 where no term is tiny. */
LOOP int64_t end_sum(
    npy_intp count, const Total *total, double unit, double *restrict lo,
    double *restrict negated_hi, double *restrict size, double *restrict slack)
{
    int64_t rare = 0;
    for (npy_intp i = 0; i < count; i++) {
        double low = total->lo[i], high = -total->negated_hi[i], mag = total->size[i];
        double terms = total->terms[i], step = step_of(mag, unit * total->reach[i], 1);
        /* All partial sums but the last may each lose a step. */
        double between = larger(terms - 2.0, 0.0) * step;
        double out_low = low - between, out_high = high + between;
        lo[i] = (out_low < 0.0) & (total->positive[i] > 0.0) ? 0.0 : out_low;
        negated_hi[i] = (out_high > 0.0) & (total->negative[i] > 0.0) ? 0.0 : -out_high;
        size[i] = mag;
        slack[i] = terms >= 2.0 ? step : 0.0;
        rare |= rare_of(unbounded(low, high) | !(mag < INFINITY), unit > 0.0 ? 0.0 : mag);
    }
    return rare;
}

/* Moves an operand to the component `j` along its array's last axis. */
static void to_component(Operand *operand, npy_intp j)
{
    int last = PyArray_NDIM(operand->array) - 1;
    npy_intp length = PyArray_DIM(operand->array, last), stride = 0;
    if (length > 1) stride = PyArray_STRIDE(operand->array, last) / (npy_intp)sizeof(double);
    operand->kind = GATHERED;
    operand->data = (const double *)PyArray_DATA(operand->array) + j * stride;
}

static void to_term(Value *a, npy_intp j)
{
    to_component(&a->lo, j);
    if (!a->exact) to_component(&a->hi, j);
    if (!a->plain) to_component(&a->mag, j);
    if (a->slackened) to_component(&a->slack, j);
    if (a->reaching) to_component(&a->reach, j);
}

/* Adds a term to the total, or begins with it. */
static void add_term(Total *total, const Value *term, npy_intp count, int first, int tiny)
{
    if (first) {
        first_term(count, term, total);
        memset(total->reach, 0, sizeof total->reach);
    } else {
        round_downward();
        add_bounds(count, term, total);
        round_to_nearest();
        add_sizes(count, term, total);
    }
    if (tiny) add_reach(count, term->reached, total->reach);
}

/* The sums of a block; what is rare in it. */
static int64_t sum_terms(Pass *pass, Total *total, npy_intp terms, npy_intp start)
{
    Value *a = &pass->a;
    Result *result = &pass->result;
    for (npy_intp j = 0; j < terms; j++) {
        to_term(a, j);
        at_block(pass, start, 1);
        add_term(total, a, pass->count, j == 0, pass->tiny);
    }
    if (pass->tiny)
        memcpy(result->reached + start, total->reach, pass->count * sizeof *total->reach);
    return end_sum(pass->count, total, pass->tiny ? SMALLEST_NORMAL * (double)terms : 0.0, pass->lo,
                   pass->negated_hi, result->size + start, result->step + start);
}

/* A band's flags, each joined over the last axis. */
static PyObject *flags_over_last(PyObject *band)
{
    PyObject *flags = SLOT(band, bands.flags);
    if (flagless(flags)) return Py_NewRef(flags);
    PyObject *carrier = PyObject_CallMethod(band, "join_flags_over_last", NULL);
    if (!carrier) return NULL;
    flags = Py_NewRef(SLOT(carrier, bands.flags));
    Py_DECREF(carrier);
    return flags;
}

static PyObject *sum_last(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    Total total;
    Value *a = &pass.a;
    Result *result = &pass.result;
    if (!begin(&pass, args, given, 1)) Py_RETURN_NONE;
    int last = pass.shape.ndim - 1;
    npy_intp terms = last < 0 ? 1 : pass.shape.dims[last];
    if (terms < 2 || !of_one_shape(a)) Py_RETURN_NONE;
    pass.shape.dims[last] = 1;
    pass.shape.size /= terms;
    prepare_value(a, &pass.shape);
    if (make_room(result, &pass.shape, 1, 1)) return NULL;
    result->count = (double)terms;
    if (a->reaching && reach_too(&pass)) return NULL;
    for (npy_intp start = 0; start < pass.shape.size && !result->rare; start += BLOCK) {
        result->rare = sum_terms(&pass, &total, terms, start);
        end_block(&pass, start);
        if (result->rare == TINY_TERMS && !pass.tiny) {
            if (reach_too(&pass)) return NULL;
            start = -BLOCK;
        }
    }
    if (!pass.rearrange) drop_terms(result);
    return flagged(&pass, result->rare ? NULL : flags_over_last(args[0]));
}

#endif
