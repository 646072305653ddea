#include "FaceBakerFactory.h"

#include "EditorFramework/AssetImportData.h"
#include "FaceBakerAsset.h"
#include "Misc/FeedbackContext.h"
#include "Misc/FileHelper.h"

UFaceBakerFactory::UFaceBakerFactory(const FObjectInitializer& Initializer) : Super(Initializer) {
  bEditorImport = true;
  SupportedClass = UFaceBakerAsset::StaticClass();
  Formats.Add(TEXT("fbk;FaceBaker archive"));
}

UObject* UFaceBakerFactory::FactoryCreateFile(UClass* InClass, UObject* InParent, FName InName, EObjectFlags Flags,
                                              const FString& Filename, const TCHAR* Parameters,
                                              FFeedbackContext* Warnings, bool& bCancelled) {
  bCancelled = false;
  TArray<uint8> Bytes;
  if (!FFileHelper::LoadFileToArray(Bytes, *Filename)) {
    Warnings->Logf(ELogVerbosity::Error, TEXT("%s cannot be read"), *Filename);
    return nullptr;
  }
  const FString Wrong = UFaceBakerAsset::WhatIsWrong(Bytes);
  if (!Wrong.IsEmpty()) {
    Warnings->Logf(ELogVerbosity::Error, TEXT("%s: %s"), *Filename, *Wrong);
    return nullptr;
  }
  UFaceBakerAsset* Asset = NewObject<UFaceBakerAsset>(InParent, InClass, InName, Flags);
  Asset->Archive = MoveTemp(Bytes);
  Asset->AssetImportData = NewObject<UAssetImportData>(Asset, TEXT("AssetImportData"));
  Asset->AssetImportData->Update(Filename);
  return Asset;
}
