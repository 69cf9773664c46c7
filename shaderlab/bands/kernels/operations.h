/* What Python calls: a pass, and the Python function that does what the pass leaves to it. */

#ifndef SHADERLAB_OPERATIONS_H
#define SHADERLAB_OPERATIONS_H

typedef PyObject *(*Kernel)(PyObject *self, PyObject *const *args, Py_ssize_t given);

typedef struct {
    PyObject_HEAD
    vectorcallfunc call;
    Kernel kernel;
    PyObject *plain, *names;
    /* Of operators: one of the two operands is a band, and the second may stand on the left. */
    int lifts, reflected;
} Operation;

/* Whether the passes are used. */
static int in_use = 1;

static PyObject *call_operation(
    PyObject *self, PyObject *const *args, size_t given, PyObject *keywords)
{
    Operation *operation = (Operation *)self;
    Py_ssize_t count = PyVectorcall_NARGS(given);
    PyObject *found = NULL;
    if (in_use && !keywords) {
        if (!operation->lifts) found = operation->kernel(NULL, args, count);
        else if (count != 2) found = Py_NewRef(Py_None);
        else {
            PyObject *given[] = {args[operation->reflected], args[!operation->reflected]}, *pair[2];
            int ready = lifted(given, pair);
            found = ready ? operation->kernel(NULL, pair, 2) : Py_NewRef(Py_None);
        }
        if (found != Py_None) return found;
        Py_DECREF(found);
    }
    return PyObject_Vectorcall(operation->plain, args, given, keywords);
}

static int traverse_operation(PyObject *self, visitproc visit, void *arg)
{
    Py_VISIT(((Operation *)self)->plain);
    Py_VISIT(((Operation *)self)->names);
    return 0;
}

static int clear_operation(PyObject *self)
{
    Py_CLEAR(((Operation *)self)->plain);
    Py_CLEAR(((Operation *)self)->names);
    return 0;
}

static void free_operation(PyObject *self)
{
    PyObject_GC_UnTrack(self);
    clear_operation(self);
    PyObject_GC_Del(self);
}

/* As a function of a class, it is a method. */
static PyObject *bind_operation(PyObject *self, PyObject *instance, PyObject *type)
{
    return instance && instance != Py_None ? PyMethod_New(self, instance) : Py_NewRef(self);
}

static PyGetSetDef of_operations[] = {
    {"__dict__", PyObject_GenericGetDict, PyObject_GenericSetDict, NULL, NULL}, {0}};

static PyTypeObject operation_type = {
    PyVarObject_HEAD_INIT(NULL, 0)
    .tp_name = "shaderlab.bands._kernels.Operation",
    .tp_basicsize = sizeof(Operation),
    .tp_flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_HAVE_VECTORCALL
        | Py_TPFLAGS_METHOD_DESCRIPTOR,
    .tp_vectorcall_offset = offsetof(Operation, call),
    .tp_call = PyVectorcall_Call,
    .tp_dictoffset = offsetof(Operation, names),
    .tp_getset = of_operations,
    .tp_getattro = PyObject_GenericGetAttr,
    .tp_setattro = PyObject_GenericSetAttr,
    .tp_descr_get = bind_operation,
    .tp_traverse = traverse_operation,
    .tp_clear = clear_operation,
    .tp_dealloc = free_operation,
};

static PyObject *new_operation(Kernel kernel, PyObject *plain, int lifts, int reflected)
{
    Operation *made = PyObject_GC_New(Operation, &operation_type);
    if (!made) return NULL;
    made->call = call_operation;
    made->kernel = kernel;
    made->plain = Py_NewRef(plain);
    made->names = NULL;
    made->lifts = lifts;
    made->reflected = reflected;
    PyObject_GC_Track((PyObject *)made);
    return (PyObject *)made;
}

/* operation(name, plain): the pass of this name, and `plain` for what it leaves; `plain` itself
 * where there is no such pass. */
static PyObject *operation(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    const char *name = given == 2 ? PyUnicode_AsUTF8(args[0]) : NULL;
    if (!name) return PyErr_Occurred() ? NULL : Py_NewRef(Py_None);
    for (PyMethodDef *kernel = kernels; kernel->ml_name; kernel++)
        if (!strcmp(kernel->ml_name, name))
            return new_operation((Kernel)(void (*)(void))kernel->ml_meth, args[1], 0, 0);
    return Py_NewRef(args[1]);
}

/* operator(operation, plain, reflected): an operator of bands or literals, and `plain` for what it leaves. */
static PyObject *operator(PyObject *self, PyObject *const *args, Py_ssize_t given)
{
    if (given != 3) {
        PyErr_SetString(PyExc_TypeError, "operator() takes an operation, a function and a bool");
        return NULL;
    }
    if (!Py_IS_TYPE(args[0], &operation_type)) return Py_NewRef(args[1]);
    return new_operation(((Operation *)args[0])->kernel, args[1], 1, args[2] == Py_True);
}

/* use(passes): whether the passes are used from now on. */
static PyObject *use(PyObject *self, PyObject *passes)
{
    in_use = passes == Py_True;
    Py_RETURN_NONE;
}

#endif
