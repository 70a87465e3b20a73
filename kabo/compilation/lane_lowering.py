"""The typing and lowering of `kabo.compilation.lanes`; imported after numba is configured."""

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import make_array

from kabo.compilation import lanes

F8, I8, I4 = ir.DoubleType(), ir.IntType(64), ir.IntType(32)
F8x4, F8x8, I8x8, F4x16 = (
    ir.VectorType(F8, 4), ir.VectorType(F8, 8), ir.VectorType(I8, 8), ir.VectorType(ir.FloatType(), 16)
)  # fmt: skip
FOUR = types.UniTuple(types.float64, 4)


def teach_lanes() -> None:
    """Registers all operations with numba."""
    for function, operation in _FOURS.items():
        _teach(function, FOUR, (types.UniTuple,) * function.__code__.co_argcount, _on_fours(operation))
    _teach(lanes.four, FOUR, (types.Array, types.Integer), _four)
    _teach(lanes.put_four, types.none, (types.Array, types.Integer, types.UniTuple), _put_four)
    _teach(lanes.all_four, FOUR, (types.Float,), _all_four)
    _teach(lanes.inner, types.float64, (types.UniTuple, types.UniTuple), _inner)
    _teach(lanes.any_greater, types.boolean, (types.UniTuple, types.UniTuple), _any_greater)
    rows = (types.Array, types.Integer, types.Integer, types.UniTuple, types.Float)
    _teach(lanes.farthest, types.int64, rows, _farthest)
    columns = (types.Array, types.Integer, types.UniTuple, types.UniTuple)
    _teach(lanes.near_columns, types.int64, columns, _near_columns)


def _teach(function: Callable[..., Any], result: Any, arguments: Sequence[Any], lower: Callable[..., Any]) -> None:
    @type_callable(function)
    def _(_: Any) -> Any:
        count = len(arguments)
        if count == 1:
            return lambda a: result
        if count == 2:
            return lambda a, b: result
        if count == 3:
            return lambda a, b, c: result
        if count == 4:
            return lambda a, b, c, d: result
        return lambda a, b, c, d, e: result

    lower_builtin(function, *arguments)(lower)


def _on_fours(operation: Callable[..., Any]) -> Callable[..., Any]:
    def lower(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        return _tuple(context, builder, operation(builder, *(_vector(builder, one) for one in arguments)))

    return lower


def _vector(builder: Any, packed: Any) -> Any:
    vector = ir.Constant(F8x4, ir.Undefined)
    for k, number in enumerate(cgutils.unpack_tuple(builder, packed)):
        vector = builder.insert_element(vector, number, I4(k))
    return vector


def _tuple(context: Any, builder: Any, vector: Any) -> Any:
    return context.make_tuple(builder, FOUR, [builder.extract_element(vector, I4(k)) for k in range(4)])


def _call(builder: Any, name: str, result: Any, *arguments: Any) -> Any:
    kind = ir.FunctionType(result, [one.type for one in arguments])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), arguments)


def _shuffled(builder: Any, first: Any, second: Any, places: Sequence[int]) -> Any:
    return builder.shuffle_vector(first, second, ir.Constant(ir.VectorType(I4, len(places)), list(places)))


def _sums(builder: Any, a: Any, b: Any, c: Any) -> Any:
    ab, cc = (
        builder.fadd(_shuffled(builder, u, v, (0, 4, 2, 6)), _shuffled(builder, u, v, (1, 5, 3, 7)))
        for u, v in ((a, b), (c, c))
    )
    return builder.fadd(_shuffled(builder, ab, cc, (0, 1, 4, 5)), _shuffled(builder, ab, cc, (2, 3, 6, 7)))


def _splat(builder: Any, number: Any, vector: Any) -> Any:
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), number, I4(0))
    return _shuffled(builder, one, one, [0] * vector.count)


_FOURS: dict[Callable[..., Any], Callable[..., Any]] = {
    lanes.times: lambda builder, a, b: builder.fmul(a, b),
    lanes.fused: lambda builder, a, b, c: _call(builder, "llvm.fmuladd.v4f64", F8x4, a, b, c),
    lanes.minus: lambda builder, a, b: builder.fsub(a, b),
    lanes.plus: lambda builder, a, b: builder.fadd(a, b),
    lanes.sums: _sums,
    lanes.absolute: lambda builder, a: _call(builder, "llvm.fabs.v4f64", F8x4, a),
}


def _pointer(context: Any, builder: Any, kind: Any, array: Any, at: Any, vector: Any) -> Any:
    data = make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [at]), vector.as_pointer())


def _four(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    array, at = arguments
    pointer = _pointer(context, builder, signature.args[0], array, at, F8x4)
    return _tuple(context, builder, builder.load(pointer, align=8))


def _put_four(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    array, at, numbers = arguments
    pointer = _pointer(context, builder, signature.args[0], array, at, F8x4)
    builder.store(_vector(builder, numbers), pointer, align=8)
    return context.get_dummy_value()


def _all_four(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
    return context.make_tuple(builder, FOUR, [arguments[0]] * 4)


def _inner(_context: Any, builder: Any, _: Any, arguments: Any) -> Any:
    (a, b, c), (x, y, z) = (cgutils.unpack_tuple(builder, one) for one in arguments)
    return _fused(builder, a, x, _fused(builder, b, y, builder.fmul(c, z)))


def _fused(builder: Any, *numbers: Any) -> Any:
    return _call(builder, "llvm.fmuladd.f64", F8, *numbers)


def _any_greater(_context: Any, builder: Any, _: Any, arguments: Any) -> Any:
    greater = builder.fcmp_ordered(">", *(_vector(builder, one) for one in arguments))
    bits = builder.and_(builder.bitcast(greater, ir.IntType(4)), ir.IntType(4)(7))
    return builder.icmp_unsigned("!=", bits, ir.IntType(4)(0))


def _farthest(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    blocks, row, count, along, offset = arguments
    shape = cgutils.unpack_tuple(builder, make_array(signature.args[0])(context, builder, blocks).shape)
    start = builder.mul(row, builder.mul(I8(3), shape[2]))
    axis = [_splat(builder, number, F8x8) for number in cgutils.unpack_tuple(builder, along)]
    shift, step, mask = _splat(builder, offset, F8x8), ir.Constant(I8x8, [8] * 8), ir.Constant(I8x8, [-64] * 8)
    best = cgutils.alloca_once_value(builder, ir.Constant(I8x8, [0] * 8))
    index = cgutils.alloca_once_value(builder, ir.Constant(I8x8, list(range(8))))
    with cgutils.for_range_slice(builder, I8(0), count, I8(8), intp=I8) as (i, _):
        product = shift
        for r in (2, 1, 0):
            at = builder.add(builder.add(start, i), builder.mul(I8(r), shape[2]))
            pointer = _pointer(context, builder, signature.args[0], blocks, at, F8x8)
            product = _call(builder, "llvm.fmuladd.v8f64", F8x8, builder.load(pointer, align=8), axis[r], product)
        key = builder.or_(builder.and_(builder.bitcast(product, I8x8), mask), builder.load(index))
        builder.store(_call(builder, "llvm.smax.v8i64", I8x8, builder.load(best), key), best)
        builder.store(builder.add(builder.load(index), step), index)
    return _call(builder, "llvm.vector.reduce.smax.v8i64", I8, builder.load(best))


def _near_columns(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    rows, start, low, high = arguments
    shape = cgutils.unpack_tuple(builder, make_array(signature.args[0])(context, builder, rows).shape)
    bits = I4(0)
    for half in (0, 16):  # halves of one register each: their comparisons mask each other
        near = None
        for sides, other, comparison in ((low, 3, "<="), (high, 0, ">=")):
            for r, side in enumerate(cgutils.unpack_tuple(builder, sides)):
                at = builder.add(builder.add(start, I8(half)), builder.mul(I8(other + r), shape[1]))
                pointer = _pointer(context, builder, signature.args[0], rows, at, F4x16)
                own = builder.load(pointer, align=4)
                one = builder.fcmp_ordered(comparison, _splat(builder, side, F4x16), own)
                near = one if near is None else builder.and_(near, one)
        own = builder.zext(builder.bitcast(near, ir.IntType(16)), I4)
        bits = builder.or_(bits, builder.shl(own, I4(half)))
    return builder.zext(bits, I8)
