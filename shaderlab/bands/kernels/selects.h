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

/* What a condition is: true, false, and the side that it takes, 1, -1 or undecided 0; `undecided`
 * where that is, or NULL for nowhere. The first two are the condition's own. */
typedef struct {
    PyArrayObject *true_, *false_, *side, *undecided;
} Sides;

static int is_flag(PyObject *object)
{
    PyArrayObject *array = (PyArrayObject *)object;
    return PyArray_Check(object) && PyArray_TYPE(array) == NPY_BOOL && PyArray_ISCARRAY_RO(array);
}

static void drop_sides(Sides *sides)
{
    Py_CLEAR(sides->side);
    Py_CLEAR(sides->undecided);
}

/* Reads a condition; 0 where NumPy must do it, -1 with an exception. */
static int find_sides(Sides *sides, PyObject *condition)
{
    memset(sides, 0, sizeof *sides);
    if (!Py_IS_TYPE(condition, truths.type)) return 0;
    PyObject *yes = SLOT(condition, truths.all_true), *no = SLOT(condition, truths.all_false);
    PyArrayObject *true_ = sides->true_ = (PyArrayObject *)yes;
    PyArrayObject *false_ = sides->false_ = (PyArrayObject *)no;
    if (!is_flag(yes) || !is_flag(no) || !PyArray_SAMESHAPE(true_, false_)) return 0;
    int ndim = PyArray_NDIM(true_);
    sides->side = (PyArrayObject *)PyArray_SimpleNew(ndim, PyArray_DIMS(true_), NPY_DOUBLE);
    sides->undecided = (PyArrayObject *)PyArray_SimpleNew(ndim, PyArray_DIMS(true_), NPY_BOOL);
    if (!sides->side || !sides->undecided) {
        drop_sides(sides);
        return -1;
    }
    if (!weigh(PyArray_SIZE(true_), PyArray_DATA(true_), PyArray_DATA(false_),
               PyArray_DATA(sides->side), PyArray_DATA(sides->undecided)))
        Py_CLEAR(sides->undecided);
    return 1;
}

LOOP void take_flags(
    npy_intp count, const npy_bool *of_a, const npy_bool *of_b, const npy_bool *true_,
    const npy_bool *false_, npy_bool *restrict to)
{
    static const npy_bool none[1];
    npy_intp a = of_a ? 1 : 0, b = of_b ? 1 : 0;
    of_a = of_a ? of_a : none;
    of_b = of_b ? of_b : none;
    for (npy_intp i = 0; i < count; i++)
        to[i] = (of_a[a * i] & !false_[i]) | (of_b[b * i] & !true_[i]);
}

/* The data of a flag of a band, NULL where it is set nowhere; false where it has not the shape of
 * `like`. */
static int read_flag(PyObject *band, int flag, PyArrayObject *like, const npy_bool **data)
{
    PyArrayObject *array = flag_of(band, flag);
    *data = array ? PyArray_DATA(array) : NULL;
    return !array || (PyArray_ISCARRAY_RO(array) && PyArray_SAMESHAPE(array, like));
}

/* One of the flags of the side that is taken; NULL with an exception, or without one where NumPy
 * must do it. */
static PyObject *taken_flag(PyObject *a, PyObject *b, int flag, const Sides *sides)
{
    const npy_bool *of_a, *of_b;
    PyArrayObject *true_ = sides->true_, *undecided = flag == 2 ? sides->undecided : NULL;
    if (!read_flag(a, flag, true_, &of_a) || !read_flag(b, flag, true_, &of_b)) return NULL;
    if (!of_a && !of_b) {
        PyObject *no = PyTuple_GET_ITEM(nowhere, flag);
        return Py_NewRef(undecided ? (PyObject *)undecided : no);
    }
    if (undecided) return NULL;
    PyObject *made = PyArray_SimpleNew(PyArray_NDIM(true_), PyArray_DIMS(true_), NPY_BOOL);
    if (made)
        take_flags(PyArray_SIZE(true_), of_a, of_b, PyArray_DATA(true_),
                   PyArray_DATA(sides->false_), PyArray_DATA((PyArrayObject *)made));
    return made;
}

static PyObject *taken_flags(PyObject *a, PyObject *b, const Sides *sides)
{
    PyObject *of_a = SLOT(a, bands.flags), *of_b = SLOT(b, bands.flags);
    if (!sides->undecided && flagless(of_a) && flagless(of_b)) return Py_NewRef(nowhere);
    PyObject *flags = PyTuple_New(3);
    for (int k = 0; flags && k < 3; k++) {
        PyObject *made = taken_flag(a, b, k, sides);
        if (made) PyTuple_SET_ITEM(flags, k, made);
        else Py_CLEAR(flags);
    }
    return flags;
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

/* select(condition, a, b). */
static PyObject *select_band(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    Pass pass;
    Operand side;
    Sides sides;
    Value *a = &pass.a, *b = &pass.b;
    Result *result = &pass.result;
    if (given != 3 || !begin(&pass, args + 1, 2, 2)) Py_RETURN_NONE;
    int ready = find_sides(&sides, args[0]);
    if (ready < 0) return NULL;
    PyObject *found = NULL, *flags = ready ? taken_flags(args[1], args[2], &sides) : NULL;
    int sums = !a->plain || !b->plain, slack = a->slackened || b->slackened;
    if (!flags || !is_operand(&side, (PyObject *)sides.side) || !broadcast(&pass.shape, &side)) {
        if (!PyErr_Occurred()) found = Py_NewRef(Py_None);
        goto end;
    }
    prepare(&side, &pass.shape);
    prepare_value(a, &pass.shape);
    prepare_value(b, &pass.shape);
    if (make_room(result, &pass.shape, sums, slack)) goto end;
    if ((a->reaching || b->reaching) && reach_too(&pass)) goto end;
    result->exact = !sides.undecided && a->exact && b->exact;
    result->count = larger(a->count, b->count);
    choose_all(&pass, &side, sums, slack);
    found = flagged(&pass, flags);
    flags = NULL;
end:
    Py_XDECREF(flags);
    drop_sides(&sides);
    return found;
}

#endif
