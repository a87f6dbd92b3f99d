"""8-bit PNG in and out, and the comparison picture of the studies. NumPy and the standard library only."""
import struct
import zlib

import numpy as np


def read_png(path):
    """An 8-bit RGB or RGBA PNG as [height, width, 3]; transparent parts lie on black."""
    data = path.read_bytes()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise OSError(f"{path}: not a PNG")
    position, packed, header = 8, b"", None
    while position < len(data):
        length, kind = struct.unpack(">I4s", data[position:position + 8])
        body = data[position + 8:position + 8 + length]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        position += length + 12
    width, height, depth, color, _, _, interlaced = header
    if depth != 8 or color not in (2, 6) or interlaced:
        raise OSError(f"{path}: only 8-bit RGB and RGBA PNG without interlacing are read here")
    channels = 3 if color == 2 else 4
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + width * channels)
    pixels = np.zeros((height, width, channels), np.uint8)
    above = np.zeros((width, channels), np.int32)
    for y in range(height):
        above = unfilter(rows[y, 0], rows[y, 1:].reshape(width, channels).astype(np.int32), above)
        pixels[y] = above
    if channels == 4:
        alpha = pixels[..., 3:].astype(np.uint16)
        return (pixels[..., :3] * alpha // 255).astype(np.uint8)
    return pixels


def unfilter(kind, row, above):
    """One scanline of PNG filter method 0 (PNG specification, section 9)."""
    if kind == 0:
        return row
    if kind == 1:
        return np.cumsum(row, axis=0) & 255
    if kind == 2:
        return (row + above) & 255
    result = np.zeros_like(row)
    left = np.zeros(row.shape[1], np.int32)
    above_left = np.zeros(row.shape[1], np.int32)
    for x in range(row.shape[0]):
        up = above[x]
        if kind == 3:
            predicted = (left + up) // 2
        else:
            estimate = left + up - above_left
            to_left, to_up, to_corner = abs(estimate - left), abs(estimate - up), abs(estimate - above_left)
            predicted = np.where((to_left <= to_up) & (to_left <= to_corner), left, np.where(to_up <= to_corner, up, above_left))
        left = (row[x] + predicted) & 255
        above_left = up
        result[x] = left
    return result


def write_png(path, pixels):
    height, width, _ = pixels.shape

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, width * 3)], axis=1)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + chunk(b"IEND", b""))


def noisiest_window(image, reference, side):
    """Top left corner (y, x) of the side × side window where the image differs most from the reference."""
    squared = ((image.astype(float) - reference) ** 2).mean(axis=2)
    sums = np.pad(squared.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    windows = sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]
    return np.unravel_index(np.argmax(windows), windows.shape)


def magnified(image, corner, side, size):
    y, x = corner
    picked = np.arange(size) * side // size
    return image[y:y + side, x:x + side][picked][:, picked]


def write_comparison(path, files, strategies, size=512, gap=4):
    """The reference with a frame, beside it 3 × 2 magnified windows: the five strategies in order, then the reference."""
    images = {name: read_png(file) for name, file in files.items()}
    reference = images["reference"]
    height, width, _ = reference.shape
    side = max(8, height // 6)
    corner = noisiest_window(images["environment"], reference, side)
    inset = (size - gap) // 2
    canvas = np.full((size, size + 3 * (inset + gap), 3), 255, np.uint8)

    framed = reference.copy()
    y, x = corner
    for edge in (framed[y:y + side, x], framed[y:y + side, x + side - 1], framed[y, x:x + side], framed[y + side - 1, x:x + side]):
        edge[:] = (255, 200, 0)
    canvas[:size, :size] = framed[np.arange(size) * height // size][:, np.arange(size) * width // size]
    for index, name in enumerate([*strategies, "reference"]):
        row, column = divmod(index, 3)
        top, left = row * (inset + gap), size + gap + column * (inset + gap)
        canvas[top:top + inset, left:left + inset] = magnified(images[name], corner, side, inset)
    write_png(path, canvas)
