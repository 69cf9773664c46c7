/* One of two bands by a condition that is true, false or undecided, value by value. */

#ifndef SHADERLAB_SELECTS_H
#define SHADERLAB_SELECTS_H

/* Sides of two booleans; whether one is undecided. */
LOOP int weigh(
    npy_intp count, const npy_bool *true_, const npy_bool *false_, double *restrict side,
    npy_bool *restrict open)
{
    npy_bool any = 0;
    for (npy_intp i = 0; i < count; i++) {
        open[i] = !(true_[i] | false_[i]);
        any |= open[i];
    }
    for (npy_intp i = 0; i < count; i++) side[i] = (int)true_[i] - (int)false_[i];
    return any;
}

LOOP int64_t any_nan(npy_intp count, const double *one, const double *other)
{
    int64_t found = 0;
    for (npy_intp i = 0; i < count; i++)
        found |= (one[i] != one[i]) | (other[i] != other[i]) ? ODD : 0;
    return found;
}

/* The side that a condition takes, 1, -1 or undecided 0, as an array; `undecided` where that is,
 * or NULL for nowhere. NULL with an exception, or without one where NumPy must do it. */
static PyArrayObject *sides_of(PyObject *condition, PyArrayObject **undecided)
{
    PyArrayObject *side = NULL, *neither = NULL;
    PyObject *yes = PyObject_GetAttrString(condition, "all_true");
    PyObject *no = yes ? PyObject_GetAttrString(condition, "all_false") : NULL;
    *undecided = NULL;
    if (!no || !PyArray_Check(yes) || !PyArray_Check(no)) goto end;
    PyArrayObject *true_ = (PyArrayObject *)yes, *false_ = (PyArrayObject *)no;
    if (PyArray_TYPE(true_) != NPY_BOOL || PyArray_TYPE(false_) != NPY_BOOL) goto end;
    if (!PyArray_ISCARRAY_RO(true_) || !PyArray_ISCARRAY_RO(false_)) goto end;
    if (!PyArray_SAMESHAPE(true_, false_)) goto end;
    int ndim = PyArray_NDIM(true_);
    side = (PyArrayObject *)PyArray_SimpleNew(ndim, PyArray_DIMS(true_), NPY_DOUBLE);
    neither = (PyArrayObject *)PyArray_SimpleNew(ndim, PyArray_DIMS(true_), NPY_BOOL);
    if (!side || !neither) {
        Py_CLEAR(side);
        goto end;
    }
    npy_intp count = PyArray_SIZE(side);
    if (weigh(count, PyArray_DATA(true_), PyArray_DATA(false_), PyArray_DATA(side),
              PyArray_DATA(neither)))
        *undecided = (PyArrayObject *)Py_NewRef((PyObject *)neither);
end:
    Py_XDECREF(neither);
    Py_XDECREF(yes);
    Py_XDECREF(no);
    return side;
}

/* Takes over `undecided`. */
static PyObject *flags_of(PyArrayObject *undecided)
{
    if (!undecided) return Py_NewRef(nowhere);
    PyObject *no = PyTuple_GET_ITEM(nowhere, 0), *made = PyTuple_Pack(3, no, no, undecided);
    Py_DECREF(undecided);
    return made;
}

/* Does all blocks of a choice. */
static void choose_all(Pass *pass, Operand *sides, int sums, int slack)
{
    static const ALIGNED double none[BLOCK];
    Value *a = &pass->a, *b = &pass->b;
    Result *result = &pass->result;
    for (npy_intp start = 0; at_block(pass, start, 2); start += BLOCK) {
        npy_intp count = pass->count;
        const double *side = values_at(sides, start, count);
        double *low = result->low + start, *high = result->high + start;
        take_lesser(count, side, a->low, b->low, low);
        take_greater(count, side, a->high, b->high, high);
        if (sums) take_greater(count, side, a->size, b->size, result->size + start);
        if (pass->tiny)
            take_greater(count, side, a->reached, b->reached, result->reached + start);
        if (slack)
            take_greater(count, side, a->slackened ? values_at(&a->slack, start, count) : none,
                         b->slackened ? values_at(&b->slack, start, count) : none,
                         result->step + start);
        result->rare = any_nan(count, low, high);
    }
}

/* select(condition, a, b), of bands whose flags are set nowhere. */
static PyObject *select_band(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    Operand sides;
    Value *a = &pass.a, *b = &pass.b;
    Result *result = &pass.result;
    PyArrayObject *undecided;
    if (given != 3 || !begin(&pass, args + 1, 2, 2)) Py_RETURN_NONE;
    for (int k = 1; k < 3; k++)
        if (!flagless(SLOT(args[k], bands.flags))) Py_RETURN_NONE;
    PyArrayObject *side = sides_of(args[0], &undecided);
    if (!side) return PyErr_Occurred() ? NULL : Py_NewRef(Py_None);
    PyObject *found = NULL;
    int sums = !a->plain || !b->plain, slack = a->slackened || b->slackened;
    if (!is_operand(&sides, (PyObject *)side) || !broadcast(&pass.shape, &sides)) goto left;
    prepare(&sides, &pass.shape);
    prepare_value(a, &pass.shape);
    prepare_value(b, &pass.shape);
    if (make_room(result, &pass.shape, sums, slack)) goto end;
    if ((a->reaching || b->reaching) && reach_too(&pass)) goto end;
    result->exact = !undecided && a->exact && b->exact;
    result->count = larger(a->count, b->count);
    choose_all(&pass, &sides, sums, slack);
    Py_XINCREF(undecided);
    found = flagged(&pass, flags_of(undecided));
    goto end;
left:
    found = Py_NewRef(Py_None);
end:
    Py_DECREF(side);
    Py_XDECREF(undecided);
    return found;
}

#endif
