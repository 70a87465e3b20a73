// The arrays of a view document as typed arrays: `arrays[reference.array]`.

const KINDS = { f32: Float32Array, f64: Float64Array, u16: Uint16Array, u32: Uint32Array };

/**
 * @param {{type: string, offset: number, length: number}[]} table
 * @param {ArrayBuffer} block
 */
export function typedArrays(table, block) {
  return table.map(({ type, offset, length }) => new KINDS[type](block, offset, length));
}
