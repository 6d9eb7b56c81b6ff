#include "lib/perception/appearance/scorer.h"

#include "lib/common/error.h"
#include "lib/common/parallel.h"

namespace secondlook::perception {
namespace {

constexpr int kTrees = 150;
constexpr int kOfTheClass = 0;  // the smaller label is the one of positive scores
constexpr int kOfTheRest = 1;

cv::Ptr<cv::ml::SVM> TrainMachine(const cv::Mat& rows, const std::vector<int>& labels, int label,
                                  const KernelParameters& parameters) {
  cv::Mat sides(rows.rows, 1, CV_32S);
  int members = 0;
  for (int i = 0; i < rows.rows; ++i) {
    sides.at<int>(i) = labels[i] == label ? kOfTheClass : kOfTheRest;
    if (labels[i] == label) ++members;
  }
  const double half = 0.5 * rows.rows;
  auto machine = cv::ml::SVM::create();
  machine->setType(cv::ml::SVM::C_SVC);
  machine->setKernel(cv::ml::SVM::RBF);
  machine->setC(parameters.c);
  machine->setGamma(parameters.gamma);
  machine->setClassWeights(
      (cv::Mat_<double>(2, 1) << half / members, half / (rows.rows - members)));
  machine->setTermCriteria({cv::TermCriteria::MAX_ITER + cv::TermCriteria::EPS, 20000, 1e-3});
  machine->train(rows, cv::ml::ROW_SAMPLE, sides);
  return machine;
}

}  // namespace

Scorer Scorer::TrainMachines(const cv::Mat& rows, const std::vector<int>& labels, int classes,
                             const KernelParameters& parameters) {
  Scorer scorer;
  scorer.machines_.resize(classes);
  ParallelFor(classes, [&](int label) {
    scorer.machines_[label] = TrainMachine(rows, labels, label, parameters);
  });
  return scorer;
}

Scorer Scorer::TrainForest(const cv::Mat& rows, const std::vector<int>& labels, int classes) {
  Scorer scorer;
  scorer.forest_ = cv::ml::RTrees::create();
  scorer.forest_->setMaxDepth(25);
  scorer.forest_->setMinSampleCount(2);
  scorer.forest_->setActiveVarCount(0);  // the square root of how many there are
  scorer.forest_->setPriors(cv::Mat::ones(classes, 1, CV_64F));
  scorer.forest_->setTermCriteria({cv::TermCriteria::MAX_ITER, kTrees, 0.0});
  scorer.forest_->train(rows, cv::ml::ROW_SAMPLE, cv::Mat(labels, true));
  return scorer;
}

cv::Mat Scorer::Score(const cv::Mat& rows) const {
  cv::Mat scores;
  if (forest_) {
    cv::Mat votes;  // the first row has the labels
    forest_->getVotes(rows, votes, 0);
    votes.rowRange(1, votes.rows).convertTo(scores, CV_32F, 1.0 / kTrees);
    return scores;
  }
  scores.create(rows.rows, static_cast<int>(machines_.size()), CV_32F);
  for (int c = 0; c < scores.cols; ++c) {
    cv::Mat column;
    machines_[c]->predict(rows, column, cv::ml::StatModel::RAW_OUTPUT);
    column.copyTo(scores.col(c));
  }
  return scores;
}

void Scorer::Write(cv::FileStorage* file) const {
  if (forest_) {
    *file << "forest"
          << "{";
    forest_->write(*file);
    *file << "}";
    return;
  }
  *file << "machines"
        << "[";
  for (const cv::Ptr<cv::ml::SVM>& machine : machines_) {
    *file << "{";
    machine->write(*file);
    *file << "}";
  }
  *file << "]";
}

void Scorer::Read(const cv::FileNode& node) {
  if (!node["forest"].empty()) {
    forest_ = cv::ml::RTrees::create();
    forest_->read(node["forest"]);
    return;
  }
  for (const cv::FileNode& machine : node["machines"]) {
    machines_.push_back(cv::ml::SVM::create());
    machines_.back()->read(machine);
  }
}

}  // namespace secondlook::perception
