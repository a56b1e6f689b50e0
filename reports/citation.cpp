// SPDX-License-Identifier: MIT
#include "reports/citation.h"

#include "datasets/base/version.h"

namespace trilat {

std::string citation_bibtex() {
  const std::string program = kProgramVersion;
  const auto space = program.find(' ');
  return "% What this report was made with. Name the version, and the study's SHA-256 from the page's "
         "provenance.\n"
         "@software{trilat,\n"
         "  title   = {" +
         program.substr(0, space) +
         ": offline evaluation of trilateration with several Kinect v2 sensors},\n"
         "  version = {" +
         program.substr(space + 1) +
         "}\n"
         "}\n"
         "% The paper whose claims and tables are held against the results.\n"
         "@misc{yang2022selfcalibrated,\n"
         "  title  = {Development of a Self-Calibrated Motion Capture System by Nonlinear Trilateration of "
         "Multiple "
         "Kinects v2},\n"
         "  author = {Yang, Bowen and Dong, Haiwei and El Saddik, Abdulmotaleb},\n"
         "  year   = {2022},\n"
         "  eprint = {2212.14771},\n"
         "  archivePrefix = {arXiv}\n"
         "}\n";
}

}  // namespace trilat
