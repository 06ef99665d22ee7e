/* image.cpp - OpenImageIO behind image.h; no exception leaves this file.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Encoders write to a file in memory, whose bytes are then handed over: several of them do not notice a full disk, but
 * the caller's fwrite does. OpenImageIO's own way of encoding into memory is not open to every format, and loses the
 * directory of 16-bit TIFFs in version 2.4. */
#include "tools/shim/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

using namespace OIIO;

namespace
{

/* Encoders that make no picture file. */
const char *const no_pictures[] = {"null", "term", "zfile"};
/* Formats whose samples are floats. */
const char *const float_formats[] = {"openexr", "hdr", "fits", "rla"};

bool is_one_of(const std::string &name, const char *const *begin, const char *const *end)
{
    return std::find_if(begin, end, [&](const char *s) { return name == s; }) != end;
}

bool makes_pictures(const std::string &format)
{
    return !is_one_of(format, std::begin(no_pictures), std::end(no_pictures));
}

/* Runs `body`; true if it says so. What goes wrong ends up in `why`. */
template <class F> bool guard(char *why, size_t size, F &&body) noexcept
{
    try {
        std::string message;
        if (body(message)) return true;
        /* one line, the first */
        std::snprintf(why, size, "%s", message.substr(0, message.find('\n')).c_str());
    } catch (const std::bad_alloc &) {
        std::snprintf(why, size, "out of memory");
    } catch (const std::exception &e) {
        std::snprintf(why, size, "%s", e.what());
    } catch (...) {
        std::snprintf(why, size, "OpenImageIO failed");
    }
    return false;
}

std::unique_ptr<ImageOutput> encoder(const char *path)
{
    auto out = ImageOutput::create(path);
    if (!out) geterror(); /* take the message, or it is printed at exit */
    if (out && !makes_pictures(out->format_name())) out.reset();
    return out;
}

TypeDesc sample_type(const image &im, const ImageOutput &out)
{
    if (im.kind == IMAGE_LINEAR) return TypeDesc::FLOAT;
    return std::string(out.format_name()) == "tiff" ? TypeDesc::UINT16 : TypeDesc::UINT8;
}

/* A nameless file in memory, which can be opened by a path all the same. */
class memory_file
{
  public:
    memory_file() : fd(memfd_create("image", MFD_CLOEXEC)) {}
    ~memory_file()
    {
        if (fd >= 0) close(fd);
    }
    memory_file(const memory_file &) = delete;
    memory_file &operator=(const memory_file &) = delete;

    std::string path() const { return "/proc/self/fd/" + std::to_string(fd); }

    bool copy_to(FILE *to) const
    {
        std::vector<char> block(1 << 16);
        off_t at = 0;
        ssize_t n;
        while ((n = pread(fd, block.data(), block.size(), at)) > 0) {
            std::fwrite(block.data(), 1, size_t(n), to);
            at += n;
        }
        return n == 0;
    }

  private:
    int fd;
};

} // namespace

extern "C" image_kind image_kind_of(const char *path, bool many)
{
    image_kind kind = IMAGE_NONE;
    char why[40];
    guard(why, sizeof why, [&](std::string &) {
        auto out = encoder(path);
        if (!out) return false;
        std::string format = out->format_name();
        bool floats = is_one_of(format, std::begin(float_formats), std::end(float_formats));
        kind = floats || (many && format == "tiff") ? IMAGE_LINEAR : IMAGE_DISPLAY;
        return true;
    });
    return kind;
}

extern "C" bool image_takes_channels(const char *path)
{
    char why[40];
    return guard(why, sizeof why, [&](std::string &) {
        auto out = encoder(path);
        std::string format = out ? out->format_name() : "";
        return format == "openexr" || format == "tiff";
    });
}

extern "C" void image_extensions(char *list, size_t size)
{
    list[0] = 0;
    guard(list, size, [&](std::string &message) {
        std::vector<std::string> words;
        auto writers = Strutil::splitsv(get_string_attribute("output_format_list"), ",");
        for (string_view format : Strutil::splitsv(get_string_attribute("extension_list"), ";")) {
            auto parts = Strutil::splitsv(format, ":");
            if (parts.size() != 2 || !makes_pictures(std::string(parts[0]))) continue;
            if (std::find(writers.begin(), writers.end(), parts[0]) == writers.end()) continue;
            words.emplace_back(Strutil::splitsv(parts[1], ",")[0]);
        }
        std::sort(words.begin(), words.end());
        message = Strutil::join(words, " ");
        return false; /* the list is handed over as the message */
    });
}

extern "C" void image_threads(unsigned threads)
{
    char why[40];
    guard(why, sizeof why, [&](std::string &) { return attribute("threads", int(threads)); });
}

extern "C" bool image_write(const image *im, const char *path, FILE *file, char *why, size_t size)
{
    return guard(why, size, [&](std::string &message) {
        auto out = encoder(path);
        if (!out) {
            message = "no image format has this extension";
            return false;
        }
        std::string format = out->format_name();
        ImageSpec spec(int(im->width), int(im->height), int(im->channels), sample_type(*im, *out));
        spec.channelnames.assign(im->names, im->names + im->channels);
        spec.attribute("oiio:ColorSpace", im->kind == IMAGE_LINEAR ? "Linear" : "sRGB");
        spec.attribute("Software", "epatch");
        spec.attribute("DateTime", ""); /* or the time is put in, and no two files are equal */
        if (im->kind == IMAGE_DISPLAY) spec.attribute("oiio:dither", 1); /* smooth backgrounds show bands otherwise */
        if (format == "jpeg") {
            spec.attribute("Compression", "jpeg:95");
            spec.attribute("jpeg:subsampling", "4:4:4");
        }

        memory_file memory;
        Filesystem::IOFile stream(memory.path(), Filesystem::IOProxy::Write);
        /* Given a stream, JPEG 2000 still looks at the extension. 16-bit TIFFs come out without their directory. */
        bool streamed = format != "tiff" && out->supports("ioproxy") && out->set_ioproxy(&stream);
        if (!out->open(streamed ? path : memory.path(), spec) || !out->write_image(TypeDesc::FLOAT, im->pixels) ||
            !out->close()) {
            message = out->geterror();
            if (message.empty()) message = "the encoder failed";
            return false;
        }
        stream.close();
        message = "cannot read back what was encoded";
        return memory.copy_to(file);
    });
}

extern "C" float *image_read(const char *path, unsigned *width, unsigned *height, char *why, size_t size)
{
    float *pixels = nullptr;
    bool ok = guard(why, size, [&](std::string &message) {
        auto in = ImageInput::open(path);
        if (!in) {
            message = geterror();
            return false;
        }
        const ImageSpec &spec = in->spec();
        int channels = std::min(spec.nchannels, 3);
        *width = unsigned(spec.width);
        *height = unsigned(spec.height);
        size_t count = size_t(spec.width) * size_t(spec.height);
        pixels = static_cast<float *>(std::malloc(std::max<size_t>(1, count * 3 * sizeof(float))));
        if (!pixels) throw std::bad_alloc();
        if (!in->read_image(0, 0, 0, channels, TypeDesc::FLOAT, pixels, 3 * sizeof(float))) {
            message = in->geterror();
            return false;
        }
        for (size_t i = 0; i < count; ++i)
            for (int k = channels; k < 3; ++k) pixels[3 * i + size_t(k)] = pixels[3 * i];
        return true;
    });
    if (ok) return pixels;
    std::free(pixels);
    return nullptr;
}
