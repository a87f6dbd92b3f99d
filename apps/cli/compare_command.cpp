// lumisweep compare: how far an image is from a reference.
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "lumisweep/image/compare.h"
#include "lumisweep/image/exr.h"

namespace lumisweep::cli {

namespace {

struct CompareOptions {
    std::string image, reference;
    bool json = false;
};

void compare(const CompareOptions& options)
{
    const Comparison c = compare_images(read_exr(options.image), read_exr(options.reference));
    if (options.json) {
        nlohmann::ordered_json json;
        json["mse"] = c.mse;
        json["relmse"] = c.relmse;
        json["rmse"] = c.rmse;
        json["psnr"] =
            std::isfinite(c.psnr) ? nlohmann::ordered_json(c.psnr) : nlohmann::ordered_json(nullptr); // JSON has no ∞
        json["mean_image"] = c.mean_image;
        json["mean_reference"] = c.mean_reference;
        fmt::print("{}\n", json.dump(2));
        return;
    }
    fmt::print("mse             {:.6g}\nrelmse          {:.6g}\nrmse            {:.6g}\npsnr            {:.2f} dB\n"
               "mean image      {:.6g}\nmean reference  {:.6g}\n",
               c.mse, c.relmse, c.rmse, c.psnr, c.mean_image, c.mean_reference);
}

} // namespace

void add_compare(CLI::App& app, Command& command)
{
    CLI::App* sub = app.add_subcommand("compare", "Compares an image with a reference: mse, relmse, rmse, psnr, means");
    auto options = std::make_shared<CompareOptions>();
    sub->add_option("image", options->image, "Image")->required()->type_name("IMAGE.exr");
    sub->add_option("reference", options->reference, "Reference of the same size")
        ->required()
        ->type_name("REFERENCE.exr");
    sub->add_flag("--json", options->json, "Print JSON; an infinite psnr is null");
    sub->callback([options, &command] { command = [options] { compare(*options); }; });
}

} // namespace lumisweep::cli
