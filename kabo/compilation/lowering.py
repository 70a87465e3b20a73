"""The typing and lowering of `window`, which kabo adds to numba; imported after numba is configured."""

from collections.abc import Callable
from typing import Any

from numba.core import cgutils, types
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import make_array, populate_array


def teach_window(window: Callable[..., Any]) -> None:
    """Registers `window` with numba, because numba's slices and reshapes are calls that count references."""

    @type_callable(window)
    def _(_: Any) -> Any:
        return lambda flat, start, shape: types.Array(flat.dtype, len(shape), "C")

    @lower_builtin(window, types.Array, types.Integer, types.BaseTuple)  # type: ignore[untyped-decorator]
    def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = make_array(signature.args[0])(context, builder, arguments[0])
        made = make_array(signature.return_type)(context, builder)
        lengths = cgutils.unpack_tuple(builder, arguments[2])
        step = context.get_constant(
            types.intp, context.get_abi_sizeof(context.get_data_type(signature.return_type.dtype))
        )
        strides = [step]
        for length in reversed(lengths[1:]):
            strides.insert(0, builder.mul(strides[0], length))
        data = builder.gep(source.data, [arguments[1]])
        populate_array(made, data, lengths, strides, step, None)
        return made._getvalue()
